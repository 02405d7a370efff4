"""The measuring harness that all stages share: sweeps, charts, comparisons of methods.

- A stress test: declare one :class:`Sweep` per difficulty, or decorate its trial with
  :func:`as_sweep`. Then declare one :class:`StressStage` and call :func:`run_stress`. It runs the
  trials, charts and prints where the method breaks.
- An experiment: write a function that returns an :class:`ExperimentResult`, declare one
  :class:`Experiment`, then call :func:`run_experiment`. It writes the files and prints the rows.
- A comparison: wrap each method in :class:`Method` and call :func:`compare_methods`.
- A chart of a stage's options: declare a :class:`DialBoard`, measure its settings with
  :func:`compare_methods`, and publish a :class:`DialChart`.
- A chart of another kind: call :func:`new_chart`, draw, then :func:`add_footer` and
  :func:`write_chart`.

Other packages import from here and from these submodules:

- :mod:`.chart_style`: colours, sizes and axes of all charts.
- :mod:`.pareto` and :mod:`.pareto_chart`: the Pareto front and its chart.
- :mod:`.shares`: shares of trials, their confidence intervals, and bars of stress charts.
- :mod:`.sweep`: sweeps one by one, without the command.
- :mod:`.machine` and :mod:`.peak_memory`: processor cores, and memory of a function call.
"""

from .chart_style import Provenance, add_footer, new_chart, write_chart, write_csv
from .comparison import Method, MethodResult, compare_methods
from .dial_chart import Measured
from .experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .machine import machine_line
from .stress import StressArguments, StressStage, run_stress
from .sweep import Sweep, SweepStep, Trial, as_sweep
from .sweep_chart import ReportSpec

__all__ = [
    "Experiment",
    "ExperimentResult",
    "Measured",
    "Method",
    "MethodResult",
    "Provenance",
    "ReportSpec",
    "StressArguments",
    "StressStage",
    "Sweep",
    "SweepStep",
    "Trial",
    "TrialPlan",
    "add_footer",
    "as_sweep",
    "compare_methods",
    "machine_line",
    "new_chart",
    "result_table",
    "run_experiment",
    "run_stress",
    "write_chart",
    "write_csv",
]

"""The measuring harness that all stages share: sweeps, charts, comparisons of methods.

- A stress test: declare a :class:`Sweep` per difficulty and one :class:`StressStage`, then call
  :func:`run_stress`. It runs the trials, charts and prints where the method breaks.
- An experiment: write a function that returns an :class:`ExperimentResult`, declare one
  :class:`Experiment`, then call :func:`run_experiment`. It writes the files and prints the rows.
- A comparison: wrap each method in :class:`Method` and call :func:`compare_methods`.
- A chart of a stage's options: declare a :class:`DialBoard`, measure its settings with
  :func:`compare_methods`, and publish a :class:`DialChart`.
- A chart of another kind: :mod:`.chart_style` holds colours, axes and the footer of all charts.

Other packages import from here, from :mod:`.chart_style` (colours and axes) and from :mod:`.shares`
(figures and bars of stress charts).
"""

from .chart_labels import PointLabel, label_points
from .chart_style import Provenance, add_footer, new_chart, write_chart
from .comparison import Method, MethodResult, compare_methods
from .csv_table import write_csv
from .dial_chart import ChartWords, DialChart, FrontPlace, Measured, check_chart_arguments
from .dials import DialBoard, DialSetting
from .experiment import Experiment, ExperimentResult, TrialPlan, result_table, run_experiment
from .machine import core_count, machine_line
from .pareto import pareto_front, simplest_front
from .pareto_chart import BaselineCurve, ChartPoint, ParetoChart
from .peak_memory import peak_megabytes
from .shares import wilson_interval
from .stress import CheckReport, StressArguments, StressCheck, StressStage, run_stress
from .sweep import (
    Sweep,
    SweepResult,
    SweepStep,
    Trial,
    as_sweep,
    format_value,
    run_sweep,
    select_sweeps,
)
from .sweep_chart import ReportSpec

__all__ = [
    "BaselineCurve",
    "ChartPoint",
    "ChartWords",
    "CheckReport",
    "DialBoard",
    "DialChart",
    "DialSetting",
    "Experiment",
    "ExperimentResult",
    "FrontPlace",
    "Measured",
    "Method",
    "MethodResult",
    "ParetoChart",
    "PointLabel",
    "Provenance",
    "ReportSpec",
    "StressArguments",
    "StressCheck",
    "StressStage",
    "Sweep",
    "SweepResult",
    "SweepStep",
    "Trial",
    "TrialPlan",
    "add_footer",
    "as_sweep",
    "check_chart_arguments",
    "compare_methods",
    "core_count",
    "format_value",
    "label_points",
    "machine_line",
    "new_chart",
    "pareto_front",
    "peak_megabytes",
    "result_table",
    "run_experiment",
    "run_stress",
    "run_sweep",
    "select_sweeps",
    "simplest_front",
    "wilson_interval",
    "write_chart",
    "write_csv",
]

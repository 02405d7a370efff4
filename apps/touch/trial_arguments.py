"""Options of the commands that repeat one trial with different seeds."""

# cyclopts reads the annotations at run time, so their names must exist then.

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from cyclopts import Parameter

from ..bench import Experiment, ExperimentResult, TrialPlan, run_experiment
from .arm_rig import SensorName


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TrialArguments:
    """The options that the experiments with repeated trials share."""

    trials: int | None = None
    """Number of trials, >= 1; default: 20 (edge 10, cable 5), and fewer with --quick."""
    seed: int = 0
    """Trial k draws its pad, its noise and its start from seed + k."""
    sensor: SensorName = "good"
    """Sensor model: "ideal" has no noise, "good" a little, "real" also shear, hysteresis, creep,
    gain errors, drift, a wait and backlash, "harsh" more of them and a lag."""
    quick: bool = False
    """Run few or short trials, for a first look."""
    out: Path | None = None
    """Output folder; default: out/experiment_NAME."""
    json: bool = False
    """Print one JSON object on stdout. The table then goes to stderr."""


class Measure(Protocol):
    """Run all trials of an experiment with one sensor model."""

    def __call__(self, plan: TrialPlan, sensor: SensorName = "good", /) -> ExperimentResult:
        """Return the result."""
        ...


def measure_with(measure: Measure, sensor: SensorName, plan: TrialPlan) -> ExperimentResult:
    """Run all trials with a sensor model, and name it in the result."""
    result = measure(plan, sensor)
    return replace(result, more={"sensor": sensor, **result.more})


def run_trials(experiment: Experiment, measure: Measure, arguments: TrialArguments | None) -> int:
    """Run an experiment with the sensor model of its arguments, and return the exit code."""
    a = arguments or TrialArguments()
    return run_experiment(
        replace(experiment, measure=lambda plan: measure_with(measure, a.sensor, plan)),
        trials=a.trials,
        seed=a.seed,
        quick=a.quick,
        out=a.out,
        json=a.json,
    )

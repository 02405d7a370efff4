"""Sweeps: a task made harder step by step, with many trials at each step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from eyehand.errors import InputError

Tested = TypeVar("Tested")
"""Type of the method under test. Each stage (segmentation, grasp, …) has its own."""

MIN_PASS_RATE = 0.9
"""Minimum share of trials that must pass. A method breaks at the first value with a lower share."""

MIN_FULL_DIGITS = 1e5
"""Numbers from here on are printed with all digits. Format ``g`` would write 3e+06 for
3 000 000."""


@dataclass(frozen=True)
class Trial:
    """The outcome of one trial."""

    passed: bool
    """Whether the answer was right."""
    note: str = ""
    """What was wrong, in a few words."""
    clean: bool = True
    """Whether the answer, right or wrong, was valid (no crash, no hang, no NaN) and no safety rule
    was violated."""
    score: float | None = None
    """Agreement with the truth, in [0, 1]; None when there is nothing to compare."""
    seconds: float | None = None
    """Run time of the method, s; None when it was not called."""
    refused: bool = False
    """Whether the method itself refused the input with a reason."""
    picture: object | None = None
    """Data from which the stage draws its pictures."""


@dataclass(frozen=True)
class Sweep(Generic[Tested]):
    """One quantity that makes the task harder, and the trial to run at each of its values.

    Raises
    ------
    InputError
        If there are fewer than two values, a value is repeated, or `holds_to` is not one of the
        values.
    """

    name: str
    """Name for the command line, one word or several joined by hyphens."""
    axis: str
    """The quantity that makes the task harder, in words."""
    unit: str
    """Unit of the values as printed; empty for plain numbers."""
    values: tuple[float, ...]
    """Values from easy to hard, in the unit."""
    holds_to: float | None
    """The method must not break at any value up to this one. None if nothing is required."""
    attempt: Callable[[float, int, Tested], Trial]
    """Run one trial of a method at a value; the seed fixes everything but the difficulty."""
    right: str
    """Condition under which a trial counts as passed, in words."""
    repeats: int | None = None
    """Maximum number of trials per value; None uses all seeds."""

    def __post_init__(self) -> None:
        if len(set(self.values)) < max(len(self.values), 2):
            raise InputError(
                f"sweep {self.name} needs at least two values, all different, got {self.values}"
            )
        if self.holds_to is not None and self.holds_to not in self.values:
            raise InputError(
                f"holds_to of sweep {self.name} must be one of {self.values}, got {self.holds_to}"
            )

    def shortened(self, *bounds: float | None) -> Sweep[Tested]:
        """Return the sweep with few values: the easiest, `holds_to`, `bounds` and the hardest."""
        kept = {self.values[0], self.holds_to, *bounds, self.values[-1]}
        return replace(self, values=tuple(value for value in self.values if value in kept))

    def required_values(self) -> tuple[float, ...]:
        """Return the values at which the method must not break."""
        if self.holds_to is None:
            return ()
        return self.values[: self.values.index(self.holds_to) + 1]


def as_sweep(
    name: str,
    axis: str,
    unit: str,
    values: tuple[float, ...],
    *,
    holds_to: float | None,
    right: str,
    repeats: int | None = None,
) -> Callable[[Callable[[float, int, Tested], Trial]], Sweep[Tested]]:
    """Return a decorator that turns a trial function into its :class:`Sweep`.

    The parameters are the fields of the sweep. Its trial then stands below its difficulty.
    """

    def decorate(attempt: Callable[[float, int, Tested], Trial]) -> Sweep[Tested]:
        return Sweep(name, axis, unit, values, holds_to, attempt, right, repeats)

    return decorate


@dataclass(frozen=True)
class SweepStep:
    """All trials at one value of a sweep."""

    value: float
    """Value in the sweep's unit."""
    trials: tuple[Trial, ...]
    """One trial per seed."""

    @property
    def pass_rate(self) -> float:
        """Share of trials that passed, in [0, 1]."""
        return float(np.mean([trial.passed for trial in self.trials]))

    @property
    def below_pass_rate(self) -> bool:
        """Whether the method breaks here: a share below `MIN_PASS_RATE` of the trials passed."""
        return self.pass_rate < MIN_PASS_RATE

    @property
    def scores(self) -> tuple[float, ...]:
        """Scores of the trials that have one."""
        return tuple(trial.score for trial in self.trials if trial.score is not None)

    @property
    def median_seconds(self) -> float | None:
        """Median run time, s; None if none was measured."""
        times = [trial.seconds for trial in self.trials if trial.seconds is not None]
        return float(np.median(times)) if times else None

    @property
    def worst(self) -> Trial:
        """The worst trial: an invalid answer first, then a wrong one."""
        return min(self.trials, key=lambda trial: (trial.clean, trial.passed))


@dataclass(frozen=True)
class SweepResult:
    """A sweep and its trials."""

    sweep: Sweep
    """The sweep."""
    steps: tuple[SweepStep, ...]
    """One step per value, in the order of the values."""
    method: str = ""
    """Name of the method under test; empty if the stage tests only one."""
    others: tuple[SweepResult, ...] = ()
    """Results of the same sweep with the stage's other methods."""

    @property
    def breaks_at(self) -> float | None:
        """First value with a pass rate below `MIN_PASS_RATE`; None if there is none."""
        return next((step.value for step in self.steps if step.below_pass_rate), None)

    @property
    def shown(self) -> SweepStep:
        """The step for pictures: the first one at which the method breaks, or the hardest."""
        return next((step for step in self.steps if step.below_pass_rate), self.steps[-1])

    @property
    def faults(self) -> tuple[str, ...]:
        """One line per value at which the method fails.

        Up to `holds_to` it fails if it breaks. At every value it fails if an answer is invalid or
        a safety rule is violated. Lines of the other methods follow.
        """
        required = self.sweep.required_values()
        lines = []
        for step in self.steps:
            unclean = [trial for trial in step.trials if not trial.clean]
            if unclean or (step.below_pass_rate and step.value in required):
                trial = unclean[0] if unclean else step.worst
                name = f"{self.sweep.name}, {self.method}," if self.method else self.sweep.name
                at = f"{name} at {format_value(step.value, self.sweep.unit)}"
                passed = sum(trial.passed for trial in step.trials)
                lines.append(f"{at}: {passed} of {len(step.trials)} right; {trial.note}")
        return (*lines, *(line for other in self.others for line in other.faults))


def run_sweep(
    sweep: Sweep[Tested], seeds: Sequence[int], method: Tested, name: str = ""
) -> SweepResult:
    """Run a trial of a method, with its name, for every value and seed.

    An exception of the method is a failed and invalid trial. It does not end the sweep.

    Raises
    ------
    InputError
        If there are no seeds.
    """
    if not seeds:
        raise InputError("a sweep needs at least one seed, got none")
    used = seeds if sweep.repeats is None else seeds[: sweep.repeats]
    return SweepResult(
        sweep,
        tuple(
            SweepStep(
                value, tuple(run_guarded(sweep.attempt, value, seed, method) for seed in used)
            )
            for value in sweep.values
        ),
        name,
    )


def select_sweeps(
    sweeps: Sequence[Sweep[Tested]], only: Sequence[str] = ()
) -> tuple[Sweep[Tested], ...]:
    """Return the named sweeps, in the order of `sweeps`, or all sweeps if no name is given.

    Parameters
    ----------
    sweeps
        All sweeps.
    only
        Names to keep.

    Raises
    ------
    InputError
        If a name is unknown.
    """
    names = [sweep.name for sweep in sweeps]
    for name in only:
        if name not in names:
            raise InputError(f"no sweep is called {name!r}, expected one of {', '.join(names)}")
    return tuple(sweep for sweep in sweeps if not only or sweep.name in only)


def format_value(value: float, unit: str) -> str:
    """Format a value with its unit: ``5 mm``, ``640 px``, ``5°``, ``12``."""
    number = f"{value:g}" if abs(value) < MIN_FULL_DIGITS else f"{value:.0f}"
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


def run_guarded(attempt: Callable[..., Trial], *arguments: Any) -> Trial:
    """Run a trial; an exception of the method becomes an invalid trial."""
    try:
        return attempt(*arguments)
    # Any exception of the method is a result of the trial.
    except Exception as error:
        reason = " ".join(str(error).split())
        return Trial(False, f"raised {type(error).__name__}: {reason}", clean=False)

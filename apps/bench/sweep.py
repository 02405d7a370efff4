"""A task that gets harder step by step, tried many times a step: where it breaks, what it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

Tested = TypeVar("Tested")
"""What is put under stress: a function, of whatever the stage's trials hand it."""

BROKEN_BELOW = 0.9
"""Share of trials that must pass; where it is less, the method has broken."""

MOST_PLAIN = 1e5
"""Above this, Python would print 3e+05."""


@dataclass(frozen=True)
class Trial:
    """One try at one difficulty."""

    passed: bool
    """Whether the answer was right."""
    note: str = ""
    """What was wrong, in a few words."""
    clean: bool = True
    """Whether the answer was a proper one, right or wrong: no crash, no hang, no garbage."""
    score: float | None = None
    """How much of the truth was met, in [0, 1]; None where there is nothing to compare."""
    seconds: float | None = None
    """Time of the method; None when it was not reached."""
    refused: bool = False
    """Whether the method itself said that it has no answer, and why."""
    picture: object | None = None
    """What to show of it, for the stage's command to draw."""


@dataclass(frozen=True)
class Sweep(Generic[Tested]):
    """One way to make the task harder.

    Raises
    ------
    InputError
        If there are fewer than two values, one comes twice, or the bound is none of them.
    """

    name: str
    """One word or two with a hyphen, for the command line."""
    axis: str
    """What gets harder, in words."""
    unit: str
    """Unit of the values as printed; empty for plain numbers."""
    values: tuple[float, ...]
    """From easy to hard, in the unit."""
    holds_to: float | None
    """The bound: up to this value the method must not break; None where it may from the start."""
    attempt: Callable[[float, int, Tested], Trial]
    """Try a method once, at a value and with a seed that fixes all but the difficulty."""
    right: str
    """What counts as passed, in words."""
    repeats: int | None = None
    """Trials a value where the number of seeds asked for does not suit; None takes that number."""

    def __post_init__(self) -> None:
        if len(set(self.values)) < max(len(self.values), 2):
            raise InputError(f"sweep {self.name} needs different values, got {self.values}")
        if self.holds_to is not None and self.holds_to not in self.values:
            raise InputError(
                f"bound of sweep {self.name} must be one of {self.values}, got {self.holds_to}"
            )

    def shortened(self) -> Sweep[Tested]:
        """The same sweep at its easiest, at its bound, and at its hardest value."""
        kept = {self.values[0], self.holds_to, self.values[-1]}
        return replace(self, values=tuple(value for value in self.values if value in kept))

    def bounded(self) -> tuple[float, ...]:
        """The values that must hold."""
        if self.holds_to is None:
            return ()
        return self.values[: self.values.index(self.holds_to) + 1]


@dataclass(frozen=True)
class Step:
    """What came of one difficulty."""

    value: float
    """In the sweep's unit."""
    trials: tuple[Trial, ...]
    """One a seed."""

    @property
    def share(self) -> float:
        """Share of trials that passed, in [0, 1]."""
        return float(np.mean([trial.passed for trial in self.trials]))

    @property
    def broken(self) -> bool:
        """Whether too few passed."""
        return self.share < BROKEN_BELOW

    @property
    def scores(self) -> tuple[float, ...]:
        """Of the trials in which there was something to compare."""
        return tuple(trial.score for trial in self.trials if trial.score is not None)

    @property
    def seconds(self) -> float | None:
        """Median time, s; None where none was measured."""
        times = [trial.seconds for trial in self.trials if trial.seconds is not None]
        return float(np.median(times)) if times else None

    @property
    def worst(self) -> Trial:
        """A trial that shows what went wrong: unclean before wrong before right."""
        return min(self.trials, key=lambda trial: (trial.clean, trial.passed))


@dataclass(frozen=True)
class SweepResult:
    """What came of a sweep."""

    sweep: Sweep
    """The sweep, of any stage."""
    steps: tuple[Step, ...]
    """In the order of its values."""

    @property
    def breaks_at(self) -> float | None:
        """First value at which fewer than 90 % passed; None when all values held."""
        return next((step.value for step in self.steps if step.broken), None)

    @property
    def shown(self) -> Step:
        """The step that a picture should show: where it breaks, or the hardest."""
        return next((step for step in self.steps if step.broken), self.steps[-1])

    @property
    def faults(self) -> tuple[str, ...]:
        """How the bound was broken, one line a value; empty when it held.

        At every difficulty, also past the bound, an answer must be a clean one.
        """
        required = self.sweep.bounded()
        lines = []
        for step in self.steps:
            dirty = [trial for trial in step.trials if not trial.clean]
            if dirty or (step.broken and step.value in required):
                trial = dirty[0] if dirty else step.worst
                at = f"{self.sweep.name} at {format_value(step.value, self.sweep.unit)}"
                passed = sum(trial.passed for trial in step.trials)
                lines.append(f"{at}: {passed} of {len(step.trials)} right; {trial.note}")
        return tuple(lines)


def run_sweep(sweep: Sweep[Tested], seeds: Sequence[int], method: Tested) -> SweepResult:
    """Try every value with every seed.

    An exception of the method is a failed and unclean trial, not the end of the sweep.

    Raises
    ------
    InputError
        If there are no seeds.
    """
    return SweepResult(sweep, tuple(iterate_steps(sweep, seeds, method)))


def iterate_steps(sweep: Sweep[Tested], seeds: Sequence[int], method: Tested) -> Iterator[Step]:
    """Yield the steps of a sweep as they are done."""
    if not seeds:
        raise InputError("a sweep needs one seed at least, got none")
    used = seeds if sweep.repeats is None else seeds[: sweep.repeats]
    for value in sweep.values:
        yield Step(value, tuple(run_guarded(sweep.attempt, value, seed, method) for seed in used))


def select_sweeps(
    sweeps: Sequence[Sweep[Tested]], only: Sequence[str] = (), others: Sequence[str] = ()
) -> tuple[Sweep[Tested], ...]:
    """Give the sweeps that are named, in their own order; all when none is.

    Parameters
    ----------
    sweeps
        All there are.
    only
        Names.
    others
        What may be named as well and is no sweep.

    Raises
    ------
    InputError
        If there is no sweep of a name.
    """
    names = [*(sweep.name for sweep in sweeps), *others]
    for name in only:
        if name not in names:
            raise InputError(f"no sweep is called {name!r}, expected of {', '.join(names)}")
    return tuple(sweep for sweep in sweeps if not only or sweep.name in only)


def format_value(value: float, unit: str) -> str:
    """A value with its unit: ``5 mm``, ``640 px``, ``5°``, ``12``."""
    number = f"{value:g}" if abs(value) < MOST_PLAIN else f"{value:.0f}"
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


def run_guarded(attempt: Callable[..., Trial], *arguments: Any) -> Trial:
    """Make an attempt; an exception of the method is an unclean trial."""
    try:
        return attempt(*arguments)
    # Whatever the method raises is what the sweep wants to know.
    except Exception as error:
        reason = " ".join(str(error).split())
        return Trial(False, f"raised {type(error).__name__}: {reason}", clean=False)

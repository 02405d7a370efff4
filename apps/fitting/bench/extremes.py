"""Extreme clouds, each with what a fit must make of it, and whether it did."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from rich import box
from rich.table import Table

from ...bench import Trial
from ...bench.sweep import run_guarded
from .stress_trial import FitCallable

if TYPE_CHECKING:
    from collections.abc import Sequence

Expectation = Literal["refuse", "follow", "degrade"]
"""``refuse``: no usable solid, and a reason that names the trouble. ``follow``: the very solid of
the usual cloud, in the other frame, to 1e-5 of its size. ``degrade``: no wrong solid without a
word: an IoU of 50 % or more, or a refusal; of points of no solid, nothing larger than they."""


@dataclass(frozen=True)
class Extreme:
    """One extreme cloud and what is expected of a fit."""

    name: str
    """What the cloud is, in words."""
    expected: Expectation
    attempt: Callable[[int, FitCallable], Trial]
    """Try a method once, with the seed of the solid and its points."""
    says: str = ""
    """Words that a refusal must hold."""


@dataclass(frozen=True)
class ExtremeResult:
    """What came of one extreme cloud."""

    extreme: Extreme
    trials: tuple[Trial, ...]
    """One a seed."""

    @property
    def kept(self) -> bool:
        """Whether every trial did what is expected, and cleanly."""
        return all(trial.passed and trial.clean for trial in self.trials)

    @property
    def happened(self) -> str:
        """What the fit did at its worst, in a few words."""
        worst = min(self.trials, key=lambda trial: (trial.clean, trial.passed))
        if not (worst.passed and worst.clean):
            return worst.note
        refused = sum(trial.refused for trial in self.trials)
        if refused == len(self.trials):
            return "refused"
        return f"{refused} of {len(self.trials)} refused" if refused else "fitted"

    @property
    def fault(self) -> str:
        """How the expectation was broken, one line; empty when it was kept."""
        if self.kept:
            return ""
        passed = sum(trial.passed for trial in self.trials)
        expected, name = self.extreme.expected, self.extreme.name
        return f"{name}: must {expected}, {passed} of {len(self.trials)} did; {self.happened}"


def run_extreme(extreme: Extreme, seeds: Sequence[int], method: FitCallable) -> ExtremeResult:
    """Try an extreme with every seed; an exception is an unclean trial."""
    return ExtremeResult(
        extreme, tuple(run_guarded(extreme.attempt, seed, method) for seed in seeds)
    )


def extreme_rows(results: Sequence[ExtremeResult]) -> list[dict[str, Any]]:
    """One row an extreme: what was expected, what happened."""
    return [
        {
            "name": result.extreme.name,
            "expected": result.extreme.expected,
            "says": result.extreme.says,
            "trials": len(result.trials),
            "kept": result.kept,
            "happened": result.happened,
        }
        for result in results
    ]


def extreme_table(results: Sequence[ExtremeResult]) -> Table:
    """The same for people; what was broken stands out."""
    table = Table(title="extreme clouds", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("cloud", "must", "kept", "what it did"):
        table.add_column(column)
    for result in results:
        must = result.extreme.expected
        if result.extreme.says:
            must += f": “{result.extreme.says}”"
        table.add_row(
            result.extreme.name,
            must,
            "yes" if result.kept else "NO",
            result.happened,
            style=None if result.kept else "bold red",
        )
    return table

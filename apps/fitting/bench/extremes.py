"""An extreme cloud, its expected result, and the check of a fit against it."""

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
"""``refuse``: no usable solid, and a reason that names the fault. ``follow``: the same solid as for
the usual cloud, moved with the cloud, to 1e-5 of its size. ``degrade``: no silent failure: an IoU
of 50 % or more, or a refusal; for points of no solid, a solid that does not exceed the points."""


@dataclass(frozen=True)
class Extreme:
    """One extreme cloud and the expected result of a fit."""

    name: str
    """Description of the cloud."""
    expected: Expectation
    attempt: Callable[[int, FitCallable], Trial]
    """Run a method once, with the seed of the solid and its points."""
    says: str = ""
    """Words that a refusal must contain."""


@dataclass(frozen=True)
class ExtremeResult:
    """The result of one extreme cloud."""

    extreme: Extreme
    trials: tuple[Trial, ...]
    """One trial per seed."""

    @property
    def kept(self) -> bool:
        """Whether every trial is valid and as expected."""
        return all(trial.passed and trial.clean for trial in self.trials)

    @property
    def happened(self) -> str:
        """Worst result of the fit, in a few words."""
        worst = min(self.trials, key=lambda trial: (trial.clean, trial.passed))
        if not (worst.passed and worst.clean):
            return worst.note
        refused = sum(trial.refused for trial in self.trials)
        if refused == len(self.trials):
            return "refused"
        return f"{refused} of {len(self.trials)} refused" if refused else "fitted"

    @property
    def fault(self) -> str:
        """Violation of the expectation in one line; empty if it was met."""
        if self.kept:
            return ""
        passed = sum(trial.passed for trial in self.trials)
        expected, name = self.extreme.expected, self.extreme.name
        return f"{name}: must {expected}, {passed} of {len(self.trials)} did; {self.happened}"


def run_extreme(extreme: Extreme, seeds: Sequence[int], method: FitCallable) -> ExtremeResult:
    """Run an extreme cloud with every seed. An exception is an invalid trial."""
    return ExtremeResult(
        extreme, tuple(run_guarded(extreme.attempt, seed, method) for seed in seeds)
    )


def extreme_rows(results: Sequence[ExtremeResult]) -> list[dict[str, Any]]:
    """Return a row per extreme cloud: expectation and result."""
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
    """Tabulate the results; violations are red."""
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

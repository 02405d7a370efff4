"""Single cases of a stress test beside its sweeps: one input each, with an expected reaction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic

from rich import box
from rich.markup import escape
from rich.table import Table

from ..console import tracked
from .stress import CheckReport
from .sweep import Tested, Trial, run_guarded


@dataclass(frozen=True)
class StressCase(Generic[Tested]):
    """One input and the expected reaction of the method."""

    name: str
    """Description of the input."""
    expected: str
    """What the method must do, in one word."""
    attempt: Callable[[int, Tested], Trial]
    """Run the method once with a seed."""
    reason_contains: str = ""
    """Words that a refusal must contain."""


@dataclass(frozen=True)
class CaseResult:
    """The result of one case."""

    case: StressCase[Any]
    trials: tuple[Trial, ...]
    """One trial per seed."""

    @property
    def kept(self) -> bool:
        """Whether every trial is valid and as expected."""
        return all(trial.passed and trial.clean for trial in self.trials)

    @property
    def happened(self) -> str:
        """Worst result, in a few words."""
        worst = min(self.trials, key=lambda trial: (trial.clean, trial.passed))
        if worst.note or not self.kept:
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
        must = f"{self.case.name}: must {self.case.expected}"
        return f"{must}, {passed} of {len(self.trials)} did; {self.happened}"

    def row(self) -> dict[str, Any]:
        """Return expectation and result, for JSON."""
        return {
            "name": self.case.name,
            "expected": self.case.expected,
            "reason_contains": self.case.reason_contains,
            "trials": len(self.trials),
            "kept": self.kept,
            "happened": self.happened,
        }


def run_case(case: StressCase[Tested], seeds: Sequence[int], method: Tested) -> CaseResult:
    """Run a case with every seed. An exception of the method is an invalid trial."""
    return CaseResult(case, tuple(run_guarded(case.attempt, seed, method) for seed in seeds))


def check_cases(
    title: str, cases: Sequence[StressCase[Tested]], seeds: Sequence[int], method: Tested
) -> CheckReport:
    """Run all cases with every seed, and report which expectations are violated.

    Parameters
    ----------
    title
        Title of the table and of the progress bar.
    cases
        The cases, in the order of the table.
    seeds
        Seeds of each case.
    method
        The method under test.
    """
    results = [run_case(case, seeds, method) for case in tracked(cases, title)]
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("input", "must", "kept", "result"):
        table.add_column(column)
    for result in results:
        reason = f": “{result.case.reason_contains}”" if result.case.reason_contains else ""
        # Brackets in messages are not markup.
        cells = (result.case.name, result.case.expected + reason, "yes" if result.kept else "NO")
        style = None if result.kept else "bold red"
        table.add_row(*map(escape, (*cells, result.happened)), style=style)
    faults = [result.fault for result in results if result.fault]
    return CheckReport(table, [result.row() for result in results], faults)

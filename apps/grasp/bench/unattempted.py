"""What a robot left on the table without ever trying it, and why: picks that count as failed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eyehand.grasping.report import CLEAR, NOT_TRIED
from eyehand.grasping.report import UNREACHABLE as CANNOT_REACH

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np

    from eyehand.grasping import Cell, ClearReport

REFUSED, UNREACHABLE, UNSEEN, DOUBT, FAULT = "refused", "unreachable", "unseen", "doubt", "fault"
"""Outcomes: no grasp suits it; the arm finds no way to one; it stands there, and the robot takes
nothing that it sees for it; a look left a doubt, and nothing was tried any more; nor was it as the
robot had stopped by itself."""
LEFT = re.compile(r"object (\d+): (.*)", re.DOTALL)
"""How the report says what was left alone, and why."""


@dataclass(frozen=True)
class Untried:
    """An object that no pick began on."""

    object: str
    """Its true name; empty where a doubt or a fault ended the scene."""
    outcome: str
    """Refused, unreachable, unseen, doubt or fault."""
    reason: str
    """In the robot's words."""


def untried_objects(
    left: Sequence[str],
    tried: Sequence[str],
    report: ClearReport,
    cell: Cell,
    nearest: Callable[[np.ndarray], str],
) -> tuple[Untried, ...]:
    """Tell what was not tried, and why.

    Parameters
    ----------
    left
        True names of the objects on the table at the end.
    tried
        True names of those that picks began on.
    report
        What the robot says.
    cell
        With the last scene that it saw.
    nearest
        True name of the object at a point (3,), world, m.

    Returns
    -------
    tuple of Untried
        One for each object; a single one where a doubt ended the scene, or the robot stopped by
        itself between picks; none for what stood there still when picks failed in a row.
    """
    names = [name for name in left if name not in tried]
    if not names:
        return ()
    if cell.reading.fault:
        told = bool(report.picks) and report.picks[-1].outcome == FAULT
        return () if told else (Untried("", FAULT, cell.reading.fault),)
    if not report.remaining and report.stop_reason != CLEAR:
        return (Untried("", DOUBT, report.stop_reason),)
    if any(line.endswith(NOT_TRIED) for line in report.remaining):
        return ()
    reasons = _reasons(report, cell, nearest)
    return tuple(_untried(name, reasons.get(name), report.stop_reason) for name in names)


def _reasons(
    report: ClearReport, cell: Cell, nearest: Callable[[np.ndarray], str]
) -> dict[str, str]:
    """Reasons of the robot by the true names of what they are about."""
    seen = {} if cell.scene is None else {one.label: one for one in cell.scene.objects}
    reasons = {}
    for line in report.remaining:
        found = LEFT.fullmatch(line)
        one = seen.get(int(found[1])) if found else None
        if found and one is not None:
            reasons[nearest(one.points.mean(axis=0))] = found[2]
    return reasons


def _untried(name: str, reason: str | None, stopped: str) -> Untried:
    if reason is None:
        return Untried(name, UNSEEN, f"ended with: {stopped}")
    return Untried(name, UNREACHABLE if reason.startswith(CANNOT_REACH) else REFUSED, reason)

"""Objects that a robot left on the table without a pick. They count as failed picks."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from eyehand.data_synth.scenes import MeshObject, TabletopObject, hull_volume
from eyehand.grasping import Cell, ClearReport

REFUSED, UNREACHABLE, UNSEEN, DOUBT, FAULT = "refused", "unreachable", "unseen", "doubt", "fault"
"""Outcomes: no grasp is suitable; no grasp is reachable; perception did not find the object; an
ambiguous scene ended the run; a robot fault ended the run."""
TOO_WIDE = "too_wide"
"""Outcome of a refused object that is truly wider than the gripper opens."""
LEFT = re.compile(r"object (\d+): (.*)", re.DOTALL)
"""Format of a line of the report on a remaining object: label and reason."""

MIN_SOLID_SHARE = 0.9
"""Minimum volume of the convex pieces over that of the hull. A hollow object, such as a mug, may be
gripped at its wall."""
MIN_EXCESS = 0.005
"""Minimum width beyond the stroke, m. The ends of a can are narrower than its middle: a gripper of
85 mm holds one of 88 mm."""


@dataclass(frozen=True)
class UnattemptedObject:
    """An object without a pick."""

    object: str
    """True name; empty if an ambiguous scene or a fault ended the run."""
    outcome: str
    """Refused, too_wide, unreachable, unseen, doubt or fault."""
    reason: str
    """Reason as reported by the robot."""


def unattempted_objects(
    left: Sequence[str],
    attempted: Sequence[str],
    report: ClearReport,
    cell: Cell,
    nearest: Callable[[np.ndarray], str],
    too_wide: Collection[str] = (),
) -> tuple[UnattemptedObject, ...]:
    """List the objects without a pick, and the reasons.

    Parameters
    ----------
    left
        True names of the objects on the table at the end.
    attempted
        True names of the objects with a pick.
    report
        Report of the robot.
    cell
        The cell, with its last scene.
    nearest
        True name of the object at a point (3,), world, m.
    too_wide
        True names of the objects that are too wide for the gripper.

    Returns
    -------
    tuple of UnattemptedObject
        One per object; a single one if an ambiguous scene or a fault between picks ended the run;
        none if successive failed picks ended the run.
    """
    names = [name for name in left if name not in attempted]
    if not names:
        return ()
    if cell.reading.fault:
        counted = bool(report.picks) and report.picks[-1].outcome == FAULT
        return () if counted else (UnattemptedObject("", FAULT, cell.reading.fault),)
    if not report.remaining and not report.cleared:
        return (UnattemptedObject("", DOUBT, report.stop_reason),)
    if report.ended_early:
        return ()
    reasons = _reasons(report, cell, nearest)
    rows = [_outcome(name, reasons.get(name), report.stop_reason) for name in names]
    return tuple(
        replace(row, outcome=TOO_WIDE) if row.outcome == REFUSED and row.object in too_wide else row
        for row in rows
    )


def _reasons(
    report: ClearReport, cell: Cell, nearest: Callable[[np.ndarray], str]
) -> dict[str, str]:
    """Return the reported reasons by true object name."""
    seen = {} if cell.scene is None else {one.label: one for one in cell.scene.objects}
    reasons = {}
    for line in report.remaining:
        found = LEFT.fullmatch(line)
        one = seen.get(int(found[1])) if found else None
        if found and one is not None:
            reasons[nearest(one.points.mean(axis=0))] = found[2]
    return reasons


def _outcome(name: str, reason: str | None, stopped: str) -> UnattemptedObject:
    if reason is None:
        return UnattemptedObject(name, UNSEEN, f"ended with: {stopped}")
    outcome = UNREACHABLE if ClearReport.is_unreachable(reason) else REFUSED
    return UnattemptedObject(name, outcome, reason)


def too_wide_objects(
    objects: Iterable[TabletopObject | MeshObject], stroke: float
) -> dict[str, float]:
    """Return name → narrowest width, m, of the objects that are too wide for a stroke in m.

    The true size decides, not the perceived one.
    """
    widths = {item.name: _narrowest(item) for item in objects}
    return {name: width for name, width in widths.items() if width > stroke + MIN_EXCESS}


def _narrowest(item: TabletopObject | MeshObject) -> float:
    """Return the width of an object in its narrowest direction, m; 0 for a hollow one."""
    if isinstance(item, TabletopObject):
        return 2.0 * float(item.shape.semi_axes.min())
    if len(item.pieces) > 1:
        solid = sum(hull_volume(piece) for piece in item.pieces)
        if solid < MIN_SOLID_SHARE * hull_volume(item.vertices):
            return 0.0
    return _hull_width(item.vertices)


def _hull_width(points: NDArray[np.float64]) -> float:
    """Return the least distance of two parallel planes, one on a facet, around points (N, 3), m."""
    hull = ConvexHull(points)
    heights = points[hull.vertices] @ hull.equations[:, :3].T
    return float(np.ptp(heights, axis=0).min())

"""Select the most accurate options for a time budget, from a stored Pareto front."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from eyehand.errors import InputError

from ..stored_front import FrontFormat, StoredFront, affordable

STORED_FRONT = Path(__file__).parent / "front.json"
"""The file that ``eyehand chart segmentation --store`` writes."""


@dataclass(frozen=True)
class FrontPoint:
    """One point of the Pareto front of time against accuracy."""

    name: str
    """Difference from the default options, in words."""
    dials: dict[str, int | bool]
    """Values of all charted options by field name. The other options have their defaults."""
    median_ms: float
    """Median time of a 640x480 frame on the machine of the stored front, ms."""
    worst_kinds_pct: float
    """Mean score of the three worst kinds of data, per cent. The score is the mean overlap F of
    labelled frames, and the share of right objects of frames annotated by points."""
    all_kinds_pct: float
    """Mean score of all kinds, per cent."""


FRONT_FORMAT = FrontFormat(
    "eyehand.segmentation_front/2", FrontPoint, "eyehand chart segmentation --store"
)
"""File format of the front."""


def select_point(
    milliseconds: float,
    *,
    slower: float = 1.0,
    threads: int = 2,
    front: StoredFront[FrontPoint] | None = None,
) -> FrontPoint:
    """Return the most accurate stored point within a time budget.

    Parameters
    ----------
    milliseconds
        Maximum median time of a 640x480 frame, ms. Single frames take more or less than the
        median, so leave a margin.
    slower
        Time on this machine divided by the time on the machine of the stored front.
        ``eyehand chart segmentation --quick`` measures and prints it.
    threads
        Maximum number of threads, >= 1.
    front
        Points to select from. Default: the stored ones.

    Returns
    -------
    FrontPoint
        Its stored time, multiplied by `slower`, is at most `milliseconds`.

    Raises
    ------
    InputError
        If a value is not positive, or if no point is fast enough. The message then gives the time
        of the fastest one.
    """
    if threads < 1:
        raise InputError(f"threads must be >= 1, got {threads}")
    front = FRONT_FORMAT.read(STORED_FRONT) if front is None else front
    allowed = [point for point in front.points if point.dials.get("threads", 1) <= threads]
    if not allowed:
        raise InputError(f"no stored options of the segmentation use <= {threads} threads")
    points = affordable(allowed, milliseconds, slower, "segmentation", _accuracy)
    return max(points, key=lambda point: point.worst_kinds_pct)


def _accuracy(point: FrontPoint) -> str:
    return f"score of the three worst kinds {point.worst_kinds_pct:.1f} %"

"""The most accurate settings for a time budget, from a front that was measured once and stored."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from eyehand.errors import InputError

from ..stored_front import FrontFormat, StoredFront, affordable
from .options import SegmentationOptions

STORED_FRONT = Path(__file__).parent / "front.json"
"""What ``eyehand chart segmentation --store`` wrote last."""


@dataclass(frozen=True)
class FrontPoint:
    """One setting that no other beats in both time and accuracy."""

    name: str
    """How it differs from the default, in words."""
    dials: dict[str, int | bool]
    """Options that were turned, by field name, all of them; the others keep their defaults."""
    median_ms: float
    """Median time of a 640x480 frame on the machine of the stored front, ms."""
    overlap_f_pct: float
    """Mean overlap F on the frames of the stored front, per cent."""
    boundary_f_pct: float
    """Mean boundary F, per cent."""
    found_pct: float
    """Mean share of objects with an own F above 0.75, per cent."""

    def options(self) -> SegmentationOptions:
        """Turn the dials."""
        return replace(SegmentationOptions(), **self.dials)


FORMAT = FrontFormat(
    "eyehand.segmentation_front/1", FrontPoint, "eyehand chart segmentation --store"
)
"""How the front is kept."""


def options_for_budget(
    milliseconds: float,
    *,
    slower: float = 1.0,
    threads: int = 2,
    front: StoredFront[FrontPoint] | None = None,
) -> SegmentationOptions:
    """Pick the most accurate stored settings that keep to a time budget.

    Parameters
    ----------
    milliseconds
        Longest median time of a 640x480 frame, ms. Single frames vary about the median, so leave
        room for them.
    slower
        How many times slower this machine is than that of the stored front; below 1 when it is
        faster. ``eyehand chart segmentation --quick`` measures and prints it.
    threads
        Most threads the segmentation may take, >= 1.
    front
        Points to choose from; the stored ones by default.

    Returns
    -------
    SegmentationOptions
        Settings whose stored time times `slower` is at most `milliseconds`.

    Raises
    ------
    InputError
        If a value is not positive or no point is that fast; the message tells what the fastest
        one costs.
    """
    if threads < 1:
        raise InputError(f"threads must be >= 1, got {threads}")
    front = FORMAT.read(STORED_FRONT) if front is None else front
    allowed = [point for point in front.points if point.dials.get("threads", 1) <= threads]
    if not allowed:
        raise InputError(f"no stored setting of the segmentation runs on {threads} threads")
    points = affordable(allowed, milliseconds, slower, "segmentation", _accuracy)
    return max(points, key=lambda point: point.overlap_f_pct).options()


def _accuracy(point: FrontPoint) -> str:
    return f"overlap F {point.overlap_f_pct:.1f} %"

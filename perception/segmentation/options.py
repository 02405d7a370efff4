"""The options of the segmentation that a user may change, and their choice for a time budget."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import inf, nan
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np

from eyehand.errors import InputError

from ..stored_front import FrontFormat, StoredFront, affordable
from .working_image import image_scale, scaled_area

MIN_WINDOW = 5
"""Minimum side of a scaled window, px. The plane fit of a smaller one averages too few readings."""

STORED_FRONT = Path(__file__).parent / "front.json"
"""The file that ``eyehand chart segmentation --store`` writes."""


@dataclass(frozen=True)
class SegmentationOptions:
    """Options of :func:`segment`.

    The defaults suit structured-light and stereo cameras at distances of 0.4 to 2 m.
    ``window`` and ``min_object`` are given for an image 640 px wide, see :meth:`scaled`.

    Raises
    ------
    InputError
        If a value has the wrong type, is not positive or not finite, or if ``window`` is even.
    """

    stride: int = 1
    """Segment every stride-th row and column. 2 takes a quarter of the time and makes outlines
    less accurate by up to 2 px. The labels keep the frame's size. A frame of 1280 columns or more
    is first reduced to 640 columns or more."""
    window: int = 9
    """Side of the window of a local plane fit, px, odd. A wider one averages more noise and blurs
    thin parts."""
    median: bool = True
    """Fill random gaps of single pixels, then apply a 3x3 median filter. It removes single flying
    pixels and rounds details of one pixel."""
    shift_windows: bool = True
    """Shift windows away from edges. Without it the fit is faster and blurs creases."""
    join_open: bool = True
    """Join the inside of an open object (bowl, mug, pot) to its outside."""
    join_occluded: bool = True
    """Join the parts of an object that an occluder separates."""
    colour_edges: bool = True
    """Split objects along strong straight colour edges if the frame has colour."""
    split_solids: bool = False
    """Fit one solid and two solids to each ambiguous object, and split it where two fit clearly
    better. It takes tens of ms for each ambiguous object."""
    scale_check: bool = True
    """Divide the image once more at half the resolution, and warn where both divisions disagree. It
    changes no label. Images below 448 columns, also after the stride, are not checked."""
    threads: int = 1
    """Threads of the window stages. 2 save time on idle cores and cost time on busy ones."""
    min_object: int = 120
    """Minimum size of an object, px. A lower value finds objects farther away, a higher one
    rejects more noise."""
    max_extent: float = 0.8
    """Maximum length of an object's bounding box diagonal, m. Larger things are walls, arms or
    furniture."""
    max_range: float = 4.0
    """Maximum depth of an object's readings, m: beyond the reach of the robot."""
    table_height: float | None = None
    """Known height of the support in the world frame, m, or None. It needs the camera's pose."""

    def __post_init__(self) -> None:
        for field in fields(self):
            _check(field.name, str(field.type), getattr(self, field.name))
        if self.window % 2 == 0 or self.window < 3:
            raise InputError(f"window must be odd and >= 3 px, got {self.window}")

    @classmethod
    def for_budget(
        cls, milliseconds: float, *, slower: float = 1.0, threads: int = 2
    ) -> SegmentationOptions:
        """Return the most accurate stored options for a time budget.

        The arguments and errors are those of `select_point`.
        """
        point = select_point(milliseconds, slower=slower, threads=threads)
        return replace(cls(), **point.dials)

    def scaled(self, width: int) -> SegmentationOptions:
        """Return the options for an image `width` px wide, with the same angles in the image."""
        scale = image_scale(width)
        return replace(
            self,
            window=max(2 * round((self.window * scale - 1) / 2) + 1, MIN_WINDOW),
            min_object=scaled_area(self.min_object, scale),
        )


def _check(name: str, kind: str, value: Any) -> None:
    """Raise an `InputError` unless a value has its field's type, and is finite and positive."""
    if value is None and "None" in kind:
        return
    if kind == "bool":
        if not isinstance(value, bool):
            raise InputError(f"segmentation option {name} must be true or false, got {value!r}")
        return
    numbers, word = (Integral, "a whole number") if kind == "int" else (Real, "finite")
    amount = nan
    if isinstance(value, numbers) and not isinstance(value, bool):
        amount = np.float64(value)
    minimum = -inf if name == "table_height" else 0.0
    if not minimum < amount < inf:
        bound = "" if minimum < 0 else " and > 0"
        raise InputError(f"segmentation option {name} must be {word}{bound}, got {value!r}")


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

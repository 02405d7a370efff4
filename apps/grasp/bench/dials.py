"""Named settings of perception and control for whole picks: what a chart turns, what a trial names.

A trial names its settings, so that it fits into one line of text and means the same on every
machine; what a name stands for is told here and nowhere else.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from eyehand.errors import InputError
from eyehand.grasping import PickOptions
from eyehand.perception import FitOptions, PerceiveOptions, SegmentationOptions

if TYPE_CHECKING:
    from collections.abc import Iterable

DEFAULT = "default"
"""Name of what users get, in both tables."""

SMALLEST_PX = 80
"""Least pixels of an object in the cell: at the camera's distance of 0.85 m, one of 20 mm has 120
in reach of the noise."""
FAST_SEGMENTATION_MS, FAST_FIT_MS = 15.0, 8.0
"""Budgets of fast perception, ms on the machine of the stored fronts: the shortest at which more
than nine of ten objects are still told apart, and fits keep most of their overlap."""
FINE_POINTS, FINE_STARTS, FINE_MINIMA, FINE_RAYS = 4000, 9, 5, 64
"""Fine perception: points of a fit, places it begins from and ends at, rays past its outline; as
much as still changes the answer."""

PERCEPTION: dict[str, str] = {
    DEFAULT: "as the demo has it: as `perceive`, down to objects of 20 mm",
    "fast": "every third pixel, one start per fit: a third of the time",
    "fine": "twice the points, more starts: twice the time",
}
"""Perception dials by name, and what each does."""

SLOW, FAST = 0.6, 1.5
"""Factors on the speeds of the hand."""
LONG_SEARCH_ROLLOUTS = 340
"""Maximum roll-outs of the search where the arm is stuck: four times the default of a pick."""

CONTROL: dict[str, str] = {
    DEFAULT: "as users get it",
    "slow": f"all speeds of the hand times {SLOW:g}",
    "fast": f"all speeds of the hand times {FAST:g}",
    "planner": f"searches with up to {LONG_SEARCH_ROLLOUTS} roll-outs where the arm is stuck",
}
"""Control dials by name, and what each does."""


def perception_dial(name: str) -> PerceiveOptions:
    """Look up the options of perception by their name.

    Raises
    ------
    InputError
        If there is no such name; the message lists those there are.
    """
    check_dials("perception", PERCEPTION, [name])
    if name == "fast":
        quick = SegmentationOptions.for_budget(FAST_SEGMENTATION_MS)
        return PerceiveOptions(
            segmentation=replace(quick, min_object=SMALLEST_PX),
            fit=FitOptions.for_budget(FAST_FIT_MS),
        )
    if name == "fine":
        fit = FitOptions(
            points=FINE_POINTS,
            starts=FINE_STARTS,
            max_minima=FINE_MINIMA,
            silhouette_rays=FINE_RAYS,
        )
        return PerceiveOptions(
            segmentation=SegmentationOptions(min_object=SMALLEST_PX),
            fit=fit,
            cloud_points=FINE_POINTS,
        )
    return PerceiveOptions(segmentation=SegmentationOptions(min_object=SMALLEST_PX))


def control_dial(name: str, base: PickOptions | None = None) -> PickOptions:
    """Look up the options of a pick by the name of a control dial.

    Parameters
    ----------
    name
        One of CONTROL.
    base
        What is turned; default: what users get.

    Raises
    ------
    InputError
        If there is no such name; the message lists those there are.
    """
    check_dials("control", CONTROL, [name])
    options = base or PickOptions()
    if name in ("slow", "fast"):
        return replace(options, speed=(SLOW if name == "slow" else FAST) * options.speed)
    if name == "planner":
        planner = replace(options.planner, rollouts=LONG_SEARCH_ROLLOUTS)
        return replace(options, planner=planner)
    return options


def check_dials(what: str, table: Iterable[str], names: Iterable[str]) -> None:
    """Raise an `InputError` for a name that the table has not."""
    known = list(table)
    for name in names:
        if name not in known:
            raise InputError(f"--{what} {name}: there is none, expected {', '.join(known)}")

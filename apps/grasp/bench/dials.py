"""Named settings (dials) of perception and control for charts and trials.

A trial stores only the names. It is then one line of text that means the same on every machine.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from eyehand.errors import InputError
from eyehand.grasping import PickOptions
from eyehand.perception import FitOptions, PerceiveOptions, SegmentationOptions
from eyehand.perception.segmentation import FRONT_FORMAT, STORED_FRONT

DEFAULT = "default"
"""Name of the default setting in both tables."""

MIN_OBJECT_PX = 80
"""Minimum number of pixels of an object. One of 20 mm has 120 pixels at the camera distance of
0.85 m."""
FAST_SEGMENTATION_SHARE, FAST_FIT_MS = 0.66, 12.0
"""Time budgets of fast perception: the segmentation's as a share of the default's stored time, the
fit's in ms on the machine of its stored front. They are the shortest at which most objects are
separated and fits keep most of their overlap."""
FINE_POINTS, FINE_STARTS, FINE_MINIMA, FINE_RAYS = 4000, 9, 5, 64
"""Fine perception: points, starts, minima and silhouette rays of a fit. Larger values do not change
the result."""

PERCEPTION: dict[str, str] = {
    DEFAULT: "the setting of the demo: as `perceive`, with objects down to 20 mm",
    "fast": "every third pixel, one start per fit; a third of the time",
    "fine": "twice the points, more starts; twice the time",
}
"""Perception dials by name, with a description."""

SLOW, FAST = 0.6, 1.5
"""Factors on the speed of the hand."""
LONG_SEARCH_ROLLOUTS = 340
"""Maximum number of roll-outs of the planner, four times the default of a pick."""

CONTROL: dict[str, str] = {
    DEFAULT: "the default options",
    "slow": f"all speeds of the hand times {SLOW:g}",
    "fast": f"all speeds of the hand times {FAST:g}",
    "fixed-grip": "the grip does not follow the load that the wrist measures",
    "planner": f"the planner runs up to {LONG_SEARCH_ROLLOUTS} roll-outs",
}
"""Control dials by name, with a description."""


def perception_dial(name: str) -> PerceiveOptions:
    """Return the perception options of a dial.

    Raises
    ------
    InputError
        If the name is unknown. The message lists the valid names.
    """
    check_dial("perception", PERCEPTION, name)
    if name == "fast":
        stored = FRONT_FORMAT.read(STORED_FRONT)
        quick = SegmentationOptions.for_budget(FAST_SEGMENTATION_SHARE * stored.default_ms)
        return PerceiveOptions(
            segmentation=replace(quick, min_object=MIN_OBJECT_PX),
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
            segmentation=SegmentationOptions(min_object=MIN_OBJECT_PX),
            fit=fit,
            cloud_points=FINE_POINTS,
        )
    return PerceiveOptions(segmentation=SegmentationOptions(min_object=MIN_OBJECT_PX))


def control_dial(name: str, base: PickOptions | None = None) -> PickOptions:
    """Return the pick options of a control dial.

    Parameters
    ----------
    name
        One of CONTROL.
    base
        Options to change; default: the default options.

    Raises
    ------
    InputError
        If the name is unknown. The message lists the valid names.
    """
    check_dial("control", CONTROL, name)
    options = base or PickOptions()
    if name in ("slow", "fast"):
        return replace(options, speed=(SLOW if name == "slow" else FAST) * options.speed)
    if name == "fixed-grip":
        return replace(options, follow_load=False)
    if name == "planner":
        planner = replace(options.planner, rollouts=LONG_SEARCH_ROLLOUTS)
        return replace(options, planner=planner)
    return options


def check_dial(what: str, table: Collection[str], name: str) -> None:
    """Raise an `InputError` for a name that is not in the table."""
    if name not in table:
        raise InputError(f"--{what} {name}: unknown, expected {', '.join(table)}")

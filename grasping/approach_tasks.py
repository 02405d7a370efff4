"""Symmetry decides which degrees of freedom the approach controls.

A ball is approached from anywhere: one row, the distance to its centre, plus the palm's direction
(2 rows). An upright cylinder leaves the side and the height free, seen from above anything round
leaves the turn. What has faces takes its orientation, and an interval along the length of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .plan import ApproachTask

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .grasp_geometry import Grip
    from .palm_placement import Stance

LEAST_CONE = 0.035
"""Tilt below which an approach is held straight, rad: so little freedom is of no use."""


def approach_tasks(grip: Grip, stance: Stance) -> tuple[ApproachTask, ...]:
    """Give the approach tasks for a grip with the palm at its place, highest priority first."""
    straight = grip.freedom == "any_side" and stance.cone < LEAST_CONE
    match "turn" if straight else grip.freedom:
        case "any_side":
            return tuple(_towards_centre(grip, stance))
        case "turn":
            return tuple(_over(grip, stance))
        case "around":
            return tuple(_around(grip, stance))
    return tuple(_before_face(grip, stance))


def _towards_centre(grip: Grip, stance: Stance) -> Iterator[ApproachTask]:
    centre, palm = grip.centre, grip.palm
    yield ApproachTask(
        "distance_to_point",
        1,
        centre,
        palm,
        stance.standoff,
        "palm at grasp distance, any side",
        recedes=1.0,
    )
    yield ApproachTask("look_at", 2, centre, palm, 0.0, "palm faces the centre, roll free")
    yield _within_cone(grip, stance.standoff, stance.cone)


def _over(grip: Grip, stance: Stance) -> Iterator[ApproachTask]:
    centre, palm = grip.centre, grip.palm
    yield ApproachTask("distance_to_axis", 2, centre, palm, 0.0, "palm over the centre")
    yield ApproachTask(
        "point_on_plane", 1, centre, -palm, stance.standoff, "palm at grasp height", recedes=1.0
    )
    yield ApproachTask("axis_alignment", 2, centre, palm, 0.0, "palm down, turn free")


def _around(grip: Grip, stance: Stance) -> Iterator[ApproachTask]:
    centre = grip.centre
    yield ApproachTask(
        "distance_to_axis",
        2,
        centre,
        grip.axis,
        0.0,
        "axis at grasp distance before the palm, from any side",
        ahead=stance.standoff,
        recedes=1.0,
    )
    yield ApproachTask(
        "axis_alignment",
        2,
        centre,
        grip.axis,
        0.0,
        "row of fingers along the axis, angle about it free",
        hand_axis="y",
    )
    yield ApproachTask(
        "point_on_plane",
        0,
        centre,
        grip.up,
        stance.low,
        "palm about the middle's height",
        high=stance.high,
    )
    if min(grip.cone, stance.cone) < np.pi:
        yield _within_cone(grip, stance.standoff, min(grip.cone, stance.cone))


def _before_face(grip: Grip, stance: Stance) -> Iterator[ApproachTask]:
    centre, palm = grip.centre, grip.palm
    along = grip.axis if grip.approach == "top" else grip.up
    place = "palm over the middle of the length" if grip.approach == "top" else "palm about the "
    if grip.approach == "side":
        place += "middle's height"
    yield ApproachTask(
        "point_on_plane", 1, centre, grip.closing, 0.0, "object midway of fingers and thumb"
    )
    yield ApproachTask(
        "point_on_plane",
        1,
        centre,
        -palm,
        stance.standoff,
        "palm at grasp distance from the face",
        recedes=1.0,
    )
    yield ApproachTask("point_on_plane", 0, centre, along, stance.low, place, high=stance.high)
    yield ApproachTask(
        "orientation",
        3,
        centre,
        grip.closing,
        0.0,
        f"palm {'down' if grip.approach == 'top' else 'to the face'}, closing across the object",
        palm=palm,
    )


def _within_cone(grip: Grip, standoff: float, cone: float) -> ApproachTask:
    """Ask the hand to stay on the side that it comes from: its place along there has a bound."""
    cosine = float(np.cos(cone))
    return ApproachTask(
        "point_on_plane",
        0,
        grip.centre,
        -grip.palm,
        standoff * cosine,
        f"no more than {np.degrees(cone):.0f} degrees off the side it comes from",
        high=float("inf"),
        recedes=cosine,
    )

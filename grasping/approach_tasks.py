"""Derive the tasks of the approach from the object's symmetry.

A sphere can be approached from anywhere: one row for the distance to its centre and two for the
palm's direction. An upright cylinder leaves the side and the height free. In a top grasp of a round
object the rotation is free. An object with faces needs a full orientation, and leaves an interval
along its length.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .grasp_geometry import GraspGeometry
from .palm_placement import PalmPlacement
from .plan import ApproachTask

MIN_TILT = 0.035
"""Minimum tilt that an approach to a sphere may use, rad. A smaller freedom does not help the arm,
so the approach is then kept straight."""


def approach_tasks(geometry: GraspGeometry, placement: PalmPlacement) -> tuple[ApproachTask, ...]:
    """Return the approach tasks of a grasp, the highest priority first."""
    straight = geometry.freedom == "any_tilt" and placement.max_approach_angle < MIN_TILT
    match "turn" if straight else geometry.freedom:
        case "any_tilt":
            return tuple(_towards_centre(geometry, placement))
        case "turn":
            return tuple(_from_top(geometry, placement))
        case "around":
            return tuple(_around_axis(geometry, placement))
    return tuple(_to_face(geometry, placement))


def _towards_centre(geometry: GraspGeometry, placement: PalmPlacement) -> Iterator[ApproachTask]:
    centre, palm = geometry.centre, geometry.palm
    yield ApproachTask(
        "distance_to_point",
        1,
        centre,
        palm,
        placement.standoff,
        "palm at grasp distance, any side",
        retreat_slope=1.0,
    )
    yield ApproachTask("look_at", 2, centre, palm, 0.0, "palm faces the centre, roll free")
    yield _within_cone(geometry, placement.standoff, placement.max_approach_angle)


def _from_top(geometry: GraspGeometry, placement: PalmPlacement) -> Iterator[ApproachTask]:
    centre, palm = geometry.centre, geometry.palm
    yield ApproachTask("distance_to_axis", 2, centre, palm, 0.0, "palm over the centre")
    yield ApproachTask(
        "point_on_plane",
        1,
        centre,
        -palm,
        placement.standoff,
        "palm at grasp height",
        retreat_slope=1.0,
    )
    yield ApproachTask("axis_alignment", 2, centre, palm, 0.0, "palm down, rotation free")


def _around_axis(geometry: GraspGeometry, placement: PalmPlacement) -> Iterator[ApproachTask]:
    centre = geometry.centre
    yield ApproachTask(
        "distance_to_axis",
        2,
        centre,
        geometry.finger_row,
        0.0,
        "axis at grasp distance in front of the palm, any side",
        palm_offset=placement.standoff,
        retreat_slope=1.0,
    )
    yield ApproachTask(
        "axis_alignment",
        2,
        centre,
        geometry.finger_row,
        0.0,
        "row of fingers along the axis, angle about it free",
        hand_axis="y",
    )
    yield ApproachTask(
        "point_on_plane",
        0,
        centre,
        geometry.up,
        placement.low,
        "palm near the middle of the height",
        upper=placement.high,
    )
    max_angle = min(geometry.max_approach_angle, placement.max_approach_angle)
    if max_angle < np.pi:
        yield _within_cone(geometry, placement.standoff, max_angle)


def _to_face(geometry: GraspGeometry, placement: PalmPlacement) -> Iterator[ApproachTask]:
    centre, palm = geometry.centre, geometry.palm
    top = geometry.approach == "top"
    along, extent = (geometry.finger_row, "length") if top else (geometry.up, "height")
    yield ApproachTask(
        "point_on_plane", 1, centre, geometry.closing, 0.0, "object midway of fingers and thumb"
    )
    yield ApproachTask(
        "point_on_plane",
        1,
        centre,
        -palm,
        placement.standoff,
        "palm at grasp distance from the face",
        retreat_slope=1.0,
    )
    yield ApproachTask(
        "point_on_plane",
        0,
        centre,
        along,
        placement.low,
        f"palm near the middle of the {extent}",
        upper=placement.high,
    )
    yield ApproachTask(
        "orientation",
        3,
        centre,
        geometry.closing,
        0.0,
        f"palm {'down' if top else 'to the face'}, closing across the object",
        palm=palm,
    )


def _within_cone(geometry: GraspGeometry, standoff: float, max_angle: float) -> ApproachTask:
    """Bound the approach angle by a minimum distance of the palm along the palm's direction."""
    cosine = float(np.cos(max_angle))
    return ApproachTask(
        "point_on_plane",
        0,
        geometry.centre,
        -geometry.palm,
        standoff * cosine,
        f"approach within {np.degrees(max_angle):.0f} degrees of the palm's direction",
        upper=float("inf"),
        retreat_slope=cosine,
    )

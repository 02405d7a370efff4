"""Symmetry decides which degrees of freedom the approach controls.

A sphere is approached from anywhere: one row, the distance to its centre, plus the palm's
direction (2 rows). A cylinder leaves the angle about its axis free. A box has faces. Only what
has no symmetry takes a full pose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .plan import ApproachTask

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .measure import Extents
    from .prototypes import Approach

UPRIGHT_COSINE = 0.94
"""Cosine of the largest tilt at which an axis still counts as upright."""


def approach_tasks(
    solid: Superquadric, extents: Extents, approach: Approach, standoff: float
) -> tuple[ApproachTask, ...]:
    """Give the approach tasks for a solid, highest priority first.

    Parameters
    ----------
    solid, extents
        The object and its measures.
    approach
        Whether the palm comes from the side or from above.
    standoff
        Distance of the palm's centre from the object's centre (or axis) at the end, m.
    """
    return tuple(_tasks(solid, extents, approach, standoff))


def _tasks(
    solid: Superquadric, extents: Extents, approach: Approach, standoff: float
) -> Iterator[ApproachTask]:
    centre, up = solid.centre, extents.up
    upright = abs(float(solid.rotation[:, 2] @ up)) > UPRIGHT_COSINE
    if solid.kind == "sphere":
        yield ApproachTask(
            "distance_to_point", 1, centre, up, standoff, "palm at grasp distance, any side"
        )
        yield ApproachTask("axis_alignment", 2, centre, up, 0.0, "palm faces the centre, roll free")
        return
    if approach == "side" and extents.round and upright:
        axis = solid.rotation[:, 2]
        yield ApproachTask(
            "distance_to_axis", 1, centre, axis, standoff, "palm at grasp distance from the axis"
        )
        yield ApproachTask(
            "axis_alignment", 2, centre, axis, 0.0, "hand along the axis, angle about it free"
        )
        yield ApproachTask("point_on_plane", 1, centre, up, 0.0, "palm at the middle's height")
        return
    if approach == "top" and extents.round:
        yield ApproachTask("distance_to_axis", 2, centre, up, 0.0, "palm over the centre")
        yield ApproachTask("point_on_plane", 1, centre, up, standoff, "palm at grasp height")
        yield ApproachTask("axis_alignment", 2, centre, -up, 0.0, "palm down, turn free")
        return
    palm = palm_direction(extents, approach)
    goal = centre - standoff * palm
    yield ApproachTask("position", 3, goal, palm, 0.0, "palm before the grasp face")
    yield ApproachTask(
        "orientation", 3, centre, extents.closing, 0.0, "hand closes across the narrow side"
    )


def palm_direction(extents: Extents, approach: Approach) -> NDArray[np.float64]:
    """Unit direction (3,) in which the palm faces: down, or along the object's longer side."""
    return -extents.up if approach == "top" else np.cross(extents.up, extents.closing)

"""Clearance between the open hand and the neighbours of an object."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .box_kernels import nearest_point
from .hands import IDLE_OPENING, HandModel
from .sphere_points import evenly_on_sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SuperquadricFit

    from .grasp_geometry import GraspGeometry
    from .palm_placement import PalmPlacement
    from .prototypes import Prototype

SURFACE_POINTS = 220
"""Number of points on a neighbour's surface, about 7 mm apart on an object of the size of a
fist."""
TIP_SHARE = 0.35
"""Length of the thin end of a finger, as a share of the finger's reach."""
RETREAT_LENGTH = 0.06
"""Distance behind the grasp, against the palm's direction, over which the hand must not touch a
neighbour either, m."""
BACKGROUND = 0
"""Label of the points of what belongs to no object."""
BACKGROUND_CELL = 0.007
"""Side of the cells in which readings of the background are averaged, m. The surfaces of neighbours
have points as far apart."""
OWN_PART_GAP = 0.01
"""Distance from the grasped part up to which the open fingers pass another part of the object, m.
In a usual pre-shape they open 15 mm beyond either side of the grasped part."""


_Corners = tuple[tuple[float, float, float], tuple[float, float, float]]


class NeighbourPoints(NamedTuple):
    """Surface points of the neighbours of an object."""

    points: NDArray[np.float64]
    """Points, (M, 3), m."""
    labels: NDArray[np.int64]
    """Label of each point's object, (M,)."""


def neighbour_points(
    item: SceneObject,
    others: Sequence[SceneObject],
    hand: HandModel,
    background: NDArray[np.float64] | None = None,
) -> NeighbourPoints:
    """Sample the surfaces around an object within reach of a hand that holds it.

    The points of other objects come from the fitted solids, or from the segmented points if the fit
    failed. The hand holds the largest part of an object of several parts. Points of its other parts
    beside the closing fingers are included with its own label. Readings that belong to no object,
    `background` (K, 3) in m, are averaged in cells and have the label `BACKGROUND`.
    """
    clouds, labels = [np.zeros((0, 3))], [np.zeros(0, dtype=np.int64)]
    solid = item.fit.superquadric
    assert solid is not None
    # A sphere of this radius around the object's centre contains every hand that holds it.
    radius = (
        2.0 * float(solid.semi_axes.max()) + hand.outer_width(hand.max_opening) + hand.palm_depth
    )
    radius += float(hand.reaches.max())
    if len(item.fit.parts) > 1:
        cloud = _surface_points(item.fit, 1)
        cloud = cloud[solid.distance(cloud) > OWN_PART_GAP]
        clouds.append(cloud)
        labels.append(np.full(len(cloud), item.label, dtype=np.int64))
    if background is not None and len(background):
        near = background[np.linalg.norm(background - solid.centre, axis=1) < radius]
        clouds.append(_cell_means(near))
        labels.append(np.full(len(clouds[-1]), BACKGROUND, dtype=np.int64))
    for other in others:
        if other.label == item.label:
            continue
        fitted = other.fit.superquadric is not None and other.fit
        step = max(len(other.points) // SURFACE_POINTS, 1)
        cloud = _surface_points(other.fit) if fitted else other.points[::step]
        cloud = cloud[np.linalg.norm(cloud - solid.centre, axis=1) < radius]
        clouds.append(cloud)
        labels.append(np.full(len(cloud), other.label, dtype=np.int64))
    return NeighbourPoints(np.concatenate(clouds), np.concatenate(labels))


def hand_clearance(
    geometry: GraspGeometry,
    placement: PalmPlacement,
    boxes: NDArray[np.float64],
    neighbours: NeighbourPoints,
) -> tuple[float, int]:
    """Return the distance of the open hand to the nearest neighbour, m, and the neighbour's label.

    The open hand and its retreat are modelled by ``boxes`` (`hand_boxes`). The palm's offset is the
    mean of ``placement.low`` and ``placement.high``. A negative distance is the depth by which the
    neighbour must be pushed perpendicular to the palm's direction. Without neighbours the result
    is (inf, 0).
    """
    if not len(neighbours.points):
        return float("inf"), 0
    along = geometry.finger_row if geometry.approach == "top" else geometry.up
    offset = 0.5 * (placement.low + placement.high) * along
    palm = geometry.centre - placement.standoff * geometry.palm + offset
    axes = np.array([geometry.closing, geometry.finger_row, geometry.palm])
    gap, nearest = nearest_point(neighbours.points, palm, axes, boxes)
    return float(gap), int(neighbours.labels[nearest])


def hand_boxes(
    hand: HandModel, prototype: Prototype, opening: float, width: float
) -> NDArray[np.float64]:
    """Return the corners (B, 2, 3), m, of boxes around the open hand and its retreat.

    The axes are closing, row of fingers and palm, with the palm as origin. Two boxes bound all
    fingers of a side, a thick one up to the knuckles and a thin one at the tips. They include the
    space that the fingers pass while they close. The thumb has the width of the pinching finger.
    The idle fingers of a pincer stay open.
    """
    half_row, half_pinch = 0.5 * hand.row_width, 0.5 * hand.pinch_width
    half_fingers = half_pinch if prototype == "pincer" else half_row
    boxes = _finger_boxes(hand, opening, width, half_fingers, -1.0)
    boxes += _finger_boxes(hand, opening, width, half_pinch, 1.0)
    if prototype == "pincer":
        idle = min(opening + IDLE_OPENING, hand.max_opening)
        boxes += _finger_boxes(hand, idle, idle, half_row, -1.0)
    half_base = 0.5 * float(hand.outer_widths[0])
    behind = -hand.palm_depth - RETREAT_LENGTH
    boxes.append(((-half_base, -half_row, behind), (half_base, half_row, 0.0)))
    return np.array(boxes)


def _finger_boxes(
    hand: HandModel, opening: float, width: float, half_row: float, side: float
) -> list[_Corners]:
    """Return two boxes around the fingers (`side` -1) or the thumb (`side` 1).

    Along the closing direction, a box begins at the object's surface, or at the open fingertips if
    they are nearer to the middle. It ends at the outside of the knuckles or of the tips.
    """
    reach = hand.reach(opening)
    inner, tip_outside = 0.5 * min(opening, width), 0.5 * opening + hand.thickness
    knuckle_outside = max(0.5 * hand.outer_width(opening), tip_outside)
    knuckles = (1.0 - TIP_SHARE) * reach
    parts = (
        (min(inner, knuckle_outside), knuckle_outside, -RETREAT_LENGTH, knuckles),
        (inner, tip_outside, knuckles, reach),
    )
    return [
        (
            (min(side * near, side * far), -half_row, low),
            (max(side * near, side * far), half_row, high),
        )
        for near, far, low, high in parts
    ]


def _cell_means(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of the points (K, 3) in each cell, (M, 3), m."""
    # All points lie within less than 1024 cells. Sorting rows takes ten times as long.
    cells = np.floor(points / BACKGROUND_CELL).astype(np.int64) @ np.array([1, 1 << 10, 1 << 20])
    _, place, count = np.unique(cells, return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(place, column, len(count)) for column in points.T])
    return sums / count[:, None]


@lru_cache(maxsize=64)
def _surface_points(fit: SuperquadricFit, first: int = 0) -> NDArray[np.float64]:
    """Return points (N, 3), m, on the parts from the first one on."""
    solids = (fit.parts or (fit.superquadric,))[first:]
    return np.concatenate(
        [
            solid.project_radially(solid.centre + _SPHERE * solid.semi_axes.max())
            for solid in solids
            if solid is not None
        ]
    )


_SPHERE = evenly_on_sphere(SURFACE_POINTS)

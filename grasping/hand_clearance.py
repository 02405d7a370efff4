"""Free space for the hand between neighbours, at the places where its fingers will be."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .closing import ASIDE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SuperquadricFit

    from .grasp_geometry import Grip
    from .hand_model import HandModel
    from .palm_placement import Stance
    from .prototypes import Prototype

POINTS = 220
"""Points on a neighbour's surface: some 7 mm apart on a thing of the size of a fist."""
TIP_SHARE = 0.35
"""Share of a finger's reach, at its end, that is no thicker than its tip."""
WAY_BACK = 0.06
"""How far back along its way the hand must be free too, m."""


_Corners = tuple[tuple[float, float, float], tuple[float, float, float]]


class Neighbours(NamedTuple):
    """Surface points of all objects but one."""

    points: NDArray[np.float64]
    """(M, 3), m."""
    labels: NDArray[np.int64]
    """Label of the object of each, (M,)."""


def neighbour_points(
    item: SceneObject, others: Sequence[SceneObject], hand: HandModel
) -> Neighbours:
    """Sample the other objects near a hand at this one: solids, or what was seen without one."""
    clouds, labels = [np.zeros((0, 3))], [np.zeros(0, dtype=np.int64)]
    solid = item.fit.superquadric
    assert solid is not None
    # No part of a hand that holds it is farther from its centre.
    farthest = 2.0 * float(solid.semi_axes.max()) + hand.spread(hand.widest) + hand.palm_depth
    farthest += float(hand.reaches.max())
    for other in others:
        if other.label == item.label:
            continue
        fitted = other.fit.superquadric is not None and other.fit
        step = max(len(other.points) // POINTS, 1)
        cloud = _surface(other.fit) if fitted else other.points[::step]
        cloud = cloud[np.linalg.norm(cloud - solid.centre, axis=1) < farthest]
        clouds.append(cloud)
        labels.append(np.full(len(cloud), other.label, dtype=np.int64))
    return Neighbours(np.concatenate(clouds), np.concatenate(labels))


def finger_room(
    grip: Grip,
    prototype: Prototype,
    stance: Stance,
    opening: float,
    hand: HandModel,
    near: Neighbours,
) -> tuple[float, int]:
    """Distance from the open hand to the nearest neighbour, m, and that one's label.

    Below 0: how far that one would have to move across the palm's direction to be out of the way.
    The hand is a handful of boxes; its palm may stand anywhere in its interval: the middle counts.
    Infinite, and 0, without neighbours.
    """
    if not len(near.points):
        return float("inf"), 0
    along = grip.axis if grip.approach == "top" else grip.up
    palm = grip.centre - stance.standoff * grip.palm + 0.5 * (stance.low + stance.high) * along
    local = (near.points - palm) @ np.array([grip.closing, grip.axis, grip.palm]).T
    boxes = _hand_boxes(hand, prototype, opening, grip.width)
    low, high = boxes[:, 0, None], boxes[:, 1, None]
    outside = np.maximum(np.maximum(low - local, local - high), 0.0)
    square = np.einsum("bpk,bpk->bp", outside, outside).min(axis=0)
    nearest = int(np.argmin(square))
    if square[nearest] > 0.0:
        return float(np.sqrt(square[nearest])), int(near.labels[nearest])
    inside = np.minimum(local - low, high - local)
    # Outwards alone along the closing direction: the object is on the other side.
    outwards = np.where(high[..., 0] <= 0.0, local[:, 0] - low[..., 0], high[..., 0] - local[:, 0])
    depth = np.where((inside > 0.0).all(axis=2), np.minimum(outwards, inside[..., 1]), 0.0)
    depth = depth.max(axis=0)
    nearest = int(np.argmax(depth)) if depth.max() > 0.0 else nearest
    return -float(depth[nearest]), int(near.labels[nearest])


def _hand_boxes(
    hand: HandModel, prototype: Prototype, opening: float, width: float
) -> NDArray[np.float64]:
    """Lower and upper corners (B, 2, 3) of boxes around the open hand and its way back, m.

    Fingers take the space from where they are open to the object, as they close through it.
    A finger bulges at its knuckles and is thin at its tip. The thumb is no wider than what a
    pincer uses, and in a pincer the outer fingers stay open.
    """
    row, narrow = 0.5 * hand.row, 0.5 * hand.middle_row
    fingers = narrow if prototype == "pincer" else row
    boxes = _finger(hand, opening, width, fingers, -1.0)
    boxes += _finger(hand, opening, width, narrow, 1.0)
    if prototype == "pincer":
        idle = min(opening + ASIDE, hand.widest)
        boxes += _finger(hand, idle, idle, row, -1.0)
    base = 0.5 * float(hand.spreads[0])
    behind = -hand.palm_depth - WAY_BACK
    boxes.append(((-base, -row, behind), (base, row, 0.0)))
    return np.array(boxes)


def _finger(
    hand: HandModel, opening: float, width: float, half_row: float, side: float
) -> list[_Corners]:
    reach = hand.reach(opening)
    inner, tip = 0.5 * min(opening, width), 0.5 * opening + hand.thickness
    bulge = max(0.5 * hand.spread(opening), tip)
    knuckles = (1.0 - TIP_SHARE) * reach
    parts = (min(inner, bulge), bulge, -WAY_BACK, knuckles), (inner, tip, knuckles, reach)
    return [
        (
            (min(side * near, side * far), -half_row, low),
            (max(side * near, side * far), half_row, high),
        )
        for near, far, low, high in parts
    ]


@lru_cache(maxsize=64)
def _surface(fit: SuperquadricFit) -> NDArray[np.float64]:
    solid = fit.superquadric
    assert solid is not None
    return solid.project_radially(solid.centre + _SPHERE * solid.semi_axes.max())


def _evenly_on_sphere(count: int) -> NDArray[np.float64]:
    """Points spread over the unit sphere along a spiral of the golden angle, (count, 3)."""
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    z = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    around = np.sqrt(1.0 - z**2)
    return np.column_stack([around * np.cos(turn), around * np.sin(turn), z])


_SPHERE = _evenly_on_sphere(POINTS)

"""Clearance of candidate poses from all points of the scene and from the support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .grasp import APPROACH
from .kernels import clearances

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SupportPlane

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .surface_model import ObjectSurface

WALL_SPACING = 0.008
"""Distance between the points that stand for a container's wall, m."""
MAX_POINTS = 3000
"""Maximum number of points that are tested. More are thinned."""


def lift_above(
    candidates: Candidates, support: SupportPlane | None, hand: ParallelHand, margin: float
) -> NDArray[np.float64]:
    """Return the tips (n, 3) of candidates, moved up until no box of the open hand is too low."""
    if support is None or len(candidates) == 0:
        return candidates.tip
    deficit = np.maximum(margin - lowest_height(candidates, support, hand), 0.0)
    return candidates.tip + deficit[:, None] * support.normal


def lowest_height(
    candidates: Candidates, support: SupportPlane, hand: ParallelHand
) -> NDArray[np.float64]:
    """Return the height of the lowest corner of the open hand above the support, (n,), m."""
    boxes = np.concatenate([hand.jaw_boxes(hand.stroke), hand.fixed_boxes()])
    local_up = support.normal @ candidates.rotation
    low = np.minimum(local_up[:, None] * boxes[None, :, 0], local_up[:, None] * boxes[None, :, 1])
    return low.sum(axis=2).min(axis=1) + support.height(candidates.tip)


def scene_points(
    surfaces: Sequence[ObjectSurface], scene: Scene
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return all points that the hand must not touch, (N, 3), m, and the index of their object.

    They are the measured points of the objects, the surfaces of their solids, the walls of
    containers and the regions without readings. The last two have the index -1.
    """
    points = [surface.points for surface in surfaces]
    labels = [np.full(len(one), number, np.int64) for number, one in enumerate(points)]
    known = {surface.label for surface in surfaces}
    rest = [item.points[::5] for item in scene.objects if item.label not in known]
    rest += [_wall_points(wall) for one in scene.containers for wall in one.walls]
    rest += [region.corners for region in scene.unknown]
    points += rest
    labels += [np.full(len(one), -1, np.int64) for one in rest]
    if not points:
        return np.zeros((0, 3)), np.zeros(0, np.int64)
    cloud, label = np.concatenate(points), np.concatenate(labels)
    step = -(-len(cloud) // MAX_POINTS)
    return np.ascontiguousarray(cloud[::step]), np.ascontiguousarray(label[::step])


def hand_clearances(
    candidates: Candidates,
    opening: NDArray[np.float64],
    points: NDArray[np.float64],
    labels: NDArray[np.int64],
    hand: ParallelHand,
) -> NDArray[np.float64]:
    """Return the clearance from the own object and from others, (n, 2), m; see `.kernels`.

    Parameters
    ----------
    candidates
        Candidates.
    opening
        Distance between the pads, (n,), m.
    points, labels
        Points from :func:`scene_points`.
    hand
        The hand.
    """
    finger = np.array([[box.low, box.high] for box in hand.finger_boxes])
    return clearances(
        candidates.rotation,
        candidates.tip,
        0.5 * opening,
        candidates.object,
        points,
        labels,
        finger,
        hand.fixed_boxes(),
        APPROACH,
    )


def _wall_points(wall: object) -> NDArray[np.float64]:
    """Return a grid of points on the inner face of a container's wall, (N, 3), m."""
    corners = np.asarray(wall.corners, dtype=np.float64)  # pyright: ignore[reportAttributeAccessIssue]
    along, up = corners[1] - corners[0], corners[3] - corners[0]
    n = max(int(np.linalg.norm(along) / WALL_SPACING), 1) + 1
    m = max(int(np.linalg.norm(up) / WALL_SPACING), 1) + 1
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m))
    return corners[0] + u.reshape(-1, 1) * along + v.reshape(-1, 1) * up

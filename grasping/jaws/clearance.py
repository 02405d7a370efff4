"""Clearance of candidate poses from all points of the scene and from the support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .grasp import APPROACH
from .kernels import BLOCKED, FAR, Limits, clearances
from .point_blocks import point_blocks

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SupportPlane, Wall

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .point_blocks import PointBlocks
    from .surface_model import ObjectSurface

WALL_SPACING = 0.003
"""Distance between the points that stand for a container's wall, m."""
WALL_LAYERS = (0.0, 0.004, 0.008)
"""Depths of these points behind the inner face, m, as far as the wall is thick. A finger behind a
single layer would not be noticed."""
COARSE_RANK, FULL_RANK = 3, 5
"""Number of the distance that counts, from the smallest. Averaged points are less noisy than
readings."""


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
    boxes = hand.open_boxes
    middle, half = boxes.mean(axis=1), 0.5 * (boxes[:, 1] - boxes[:, 0])
    local_up = support.normal @ candidates.rotation
    low = local_up @ middle.T - np.abs(local_up) @ half.T
    return low.min(axis=1) + support.height(candidates.tip)


def coarse_points(surfaces: Sequence[ObjectSurface], scene: Scene) -> PointBlocks:
    """Return averaged readings, surfaces of solids, and what belongs to no object."""
    groups = [surface.points for surface in surfaces]
    return _with_background(groups, surfaces, scene)


def all_points(surfaces: Sequence[ObjectSurface], scene: Scene) -> PointBlocks:
    """Return all readings of the objects, and what belongs to no object."""
    points = {item.label: item.points for item in scene.objects}
    groups = [points[surface.label] for surface in surfaces]
    return _with_background(groups, surfaces, scene)


def _with_background(
    groups: list[NDArray[np.float64]], surfaces: Sequence[ObjectSurface], scene: Scene
) -> PointBlocks:
    """Add other objects, walls of containers, and what belongs to no object, with the label -1."""
    known = {surface.label for surface in surfaces}
    rest = [item.points for item in scene.objects if item.label not in known]
    rest += [_wall_points(wall) for one in scene.containers for wall in one.walls]
    rest += [region.corners for region in scene.unknown]
    rest += [scene.background] if len(scene.background) else []
    return point_blocks([*groups, *rest], [*range(len(groups)), *[-1] * len(rest)])


def hand_clearances(
    candidates: Candidates,
    opening: NDArray[np.float64],
    blocks: PointBlocks,
    hand: ParallelHand,
    rank: int = COARSE_RANK,
    least: NDArray[np.float64] | None = None,
    most: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Return the clearance from the own object and from others, (n, 2), m; see `.kernels`.

    Parameters
    ----------
    candidates
        Candidates.
    opening
        Distance between the pads, (n,), m.
    blocks
        Points from :func:`coarse_points` or :func:`all_points`.
    hand
        The hand.
    rank
        Number of the distance that counts, from the smallest.
    least
        Clearance below which a candidate is given up, (n,), m; None for `BLOCKED`.
    most
        Largest clearances, (n, 2), m; None for `FAR`. Small ones save time.
    """
    if least is None:
        least = np.full(len(candidates), BLOCKED)
    if most is None:
        most = np.full((len(candidates), 2), FAR)
    finger = np.array([[box.low, box.high] for box in hand.finger_boxes])
    return clearances(
        candidates.rotation,
        candidates.tip,
        0.5 * opening,
        candidates.object,
        blocks.columns,
        blocks.label,
        finger,
        hand.fixed_boxes(),
        APPROACH,
        Limits(rank, least, most),
    )


def _wall_points(wall: Wall) -> NDArray[np.float64]:
    """Return a grid of points on the inner face of a container's wall and behind it, (N, 3), m."""
    corners = wall.corners
    along, up = corners[1] - corners[0], corners[3] - corners[0]
    n = max(int(np.linalg.norm(along) / WALL_SPACING), 1) + 1
    m = max(int(np.linalg.norm(up) / WALL_SPACING), 1) + 1
    u, v = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m))
    face = corners[0] + u.reshape(-1, 1) * along + v.reshape(-1, 1) * up
    outwards = wall.axes[1]
    layers = [depth for depth in WALL_LAYERS if depth <= wall.thickness or depth == 0.0]
    return np.concatenate([face + depth * outwards for depth in layers])

"""Points that fill the space below what is known of an object.

The points of a surface lie outside a finger that is wholly inside the object: they cannot show it.
The camera may also see the top of an object alone, while others hide the rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .point_blocks import point_blocks

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SupportPlane

    from .point_blocks import PointBlocks
    from .surface_model import ObjectSurface
    from .unseen import HiddenSpace

SPACING = 0.008
"""Distance between the points, m. A finger is thicker than that, so it holds some."""


def filled_points(
    surfaces: Sequence[ObjectSurface], scene: Scene, hidden: HiddenSpace
) -> PointBlocks:
    """Return hidden points between the surfaces of objects and the support.

    An object that stands on the support usually fills the hidden space below its seen surface. The
    space below an object that rests on another one may be free, so it has no points.
    """
    resting = {item.label for item in scene.objects if item.rests_on}
    groups = []
    for surface in surfaces:
        points = np.zeros((0, 3))
        if scene.support is not None and surface.label not in resting:
            points = _below(surface, scene.support)
            points = points[hidden.hides(points)]
        groups.append(points)
    return point_blocks(groups, range(len(groups)))


def _below(surface: ObjectSurface, support: SupportPlane) -> NDArray[np.float64]:
    """Return points below the highest ones of a surface, down to the support, (N, 3), m."""
    known = surface.points[: surface.measured] if surface.vessel else surface.points
    up = support.normal
    across = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    across /= np.linalg.norm(across)
    cell = np.floor(known @ np.stack([across, np.cross(up, across)]).T / SPACING).astype(np.int64)
    height = support.height(known)
    order = np.argsort(-height, kind="stable")
    # One number for each cell: finding distinct rows takes eight times as long.
    cell -= cell.min(axis=0, initial=0)
    key = cell[:, 0] * (cell[:, 1].max(initial=0) + 1) + cell[:, 1]
    _, first = np.unique(key[order], return_index=True)
    top = order[first]
    count = np.maximum(height[top] / SPACING, 0.0).astype(int)
    step = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + 1
    return np.repeat(known[top], count, axis=0) - SPACING * step[:, None] * up

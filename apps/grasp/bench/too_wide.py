"""Objects that a gripper cannot hold, because they are wider than its stroke in all directions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull

from eyehand.data_synth.scenes import MeshObject, TabletopObject, hull_volume

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

MIN_SOLID_SHARE = 0.9
"""Minimum volume of the convex pieces over that of the hull. A hollow object, such as a mug, may be
gripped at its wall."""
MIN_EXCESS = 0.005
"""Minimum width beyond the stroke, m. The ends of a can are narrower than its middle: a gripper of
85 mm holds one of 88 mm."""


def too_wide_objects(
    objects: Iterable[TabletopObject | MeshObject], stroke: float
) -> dict[str, float]:
    """Return name → narrowest width, m, of the objects that are too wide for a stroke in m.

    The object itself decides, not what was perceived of it.
    """
    widths = {item.name: _narrowest(item) for item in objects}
    return {name: width for name, width in widths.items() if width > stroke + MIN_EXCESS}


def _narrowest(item: TabletopObject | MeshObject) -> float:
    """Return the width of an object in its narrowest direction, m; 0 for a hollow one."""
    if isinstance(item, TabletopObject):
        return 2.0 * float(item.shape.semi_axes.min())
    if len(item.pieces) > 1:
        solid = sum(hull_volume(piece) for piece in item.pieces)
        if solid < MIN_SOLID_SHARE * hull_volume(item.vertices):
            return 0.0
    return _hull_width(item.vertices)


def _hull_width(points: NDArray[np.float64]) -> float:
    """Return the least distance of two parallel planes, one on a facet, around points (N, 3), m."""
    hull = ConvexHull(points)
    heights = points[hull.vertices] @ hull.equations[:, :3].T
    return float(np.ptp(heights, axis=0).min())

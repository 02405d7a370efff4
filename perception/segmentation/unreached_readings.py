"""Readings that the supports do not explain: in front of all, or on the level of the first one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .above_support import OVERHANG
from .connected_parts import connected_parts
from .hull_depth import depth_in_hull
from .support_extent import Support
from .working_image import WorkingImage

WIDTH = 80
"""Columns of the reduced image in which the readings are counted."""
LEVEL = 0.03
"""Maximum distance from the plane of a support of readings that may continue it, m; minimum
distance from its outline."""
MIN_RISE = 0.02
"""Minimum height of these readings above all supports, m."""


def unreached_share(image: WorkingImage, supports: list[Support]) -> float:
    """Return the size of the largest connected part out of reach, as a share of the pixels, 0-1.

    A reading is out of reach if it is nearer than each support, above all of them, and more than
    ``OVERHANG`` outside their bounds in plan. A table is nearer than what stands around it. But if
    the boards of a shelf are seen edge-on, the support is a floor far behind the shelf.
    """
    if not supports:
        return 0.0
    nearest = min(float(_corners(support)[:, 2].min()) for support in supports)
    points, rows, columns, depth = _reduced(image, nearest)
    kept = np.ones(len(points), np.bool_)
    for support in supports:
        plan = points @ support.axes.T
        low, high = support.hull.min(axis=0) - OVERHANG, support.hull.max(axis=0) + OVERHANG
        kept &= ((plan < low) | (plan > high)).any(axis=-1)
        kept &= support.plane.height(points) > MIN_RISE
    unreached = np.zeros(depth.shape, np.uint8)
    unreached[rows[kept], columns[kept]] = 1
    largest = connected_parts(unreached).sizes[1:].max(initial=0)
    return float(largest) / depth.size


def continued_share(image: WorkingImage, support: Support) -> float:
    """Return how many readings on the level of a support are outside its outline, per one inside.

    Holes may cut a table into many parts. An outline around one of them loses the objects beside.
    """
    points, *_ = _reduced(image, np.inf)
    level = points[np.abs(support.plane.height(points)) < LEVEL]
    inside = np.asarray(depth_in_hull(level @ support.axes.T, support.hull))
    return float(np.count_nonzero(inside < -LEVEL) / max(np.count_nonzero(inside >= 0), 1))


def _reduced(
    image: WorkingImage, nearest: float
) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.intp], NDArray[np.float32]]:
    """Return the readings nearer than `nearest`, m, with their pixels; and the reduced image."""
    stride = max(image.intrinsics.width // WIDTH, 1)
    k = image.intrinsics.reduced(stride)
    depth = image.depth[::stride, ::stride]
    rows, columns = np.nonzero((depth > 0) & (depth < nearest))
    z = depth[rows, columns].astype(np.float64)
    points = np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])
    return points, rows, columns, depth


def _corners(support: Support) -> NDArray[np.float64]:
    """Return the corners of a support's hull, (K, 3), m, camera frame."""
    plane = support.plane
    return support.hull.astype(np.float64) @ support.axes - plane.offset * plane.normal

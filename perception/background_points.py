"""Readings above the support that belong to no object: boards, walls, fixtures."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .frame import DepthFrame
    from .segmentation import Segmentation

MIN_HEIGHT = 0.01
"""Minimum distance of a reading from every support plane, m, beside 3 σ of the plane."""
COLUMNS = 320
"""Approximate number of columns of the image whose readings are selected."""
EDGE = 1
"""Readings of that image nearer than this to an object are left out, px: they mix the object and
what is behind it."""
MIN_ALIKE, MIN_ALIKE_FRONT = 4, 2
"""Minimum number of the 8 neighbours of a reading, in the whole image, at nearly its distance, and
of one without a nearer neighbour. A column of readings that mix foreground and background has 2,
and a nearer neighbour. A post of 2 columns has 5, and one of 1 column 2."""
THIN_WEIGHT = 5
"""Number of times that a reading of a thing one pixel wide is returned. Planners leave out the 4
deepest readings as noise, and so few may be all of it that is in the hand."""
ALIKE = 0.01
"""Maximum difference of such a neighbour, as a share of the distance."""
MAX_POINTS = 8000
"""Maximum number of readings. It bounds the time of planning."""
REACH = 0.3
"""Maximum distance of a reading from the box around all objects, m: the length of a hand."""


def background_points(
    frame: DepthFrame,
    segmentation: Segmentation,
    T_scene_camera: RigidTransform,
    clouds: list[NDArray[np.float64]],
) -> NDArray[np.float64]:
    """Return readings above the support and near the objects that belong to no object.

    Parameters
    ----------
    frame
        The depth frame.
    segmentation
        Its segmentation.
    T_scene_camera
        Maps camera coordinates to those of the scene.
    clouds
        Points of the objects, (N, 3) each, scene frame, m.

    Returns
    -------
    NDArray[np.float64]
        Points (K, 3), scene frame, m; none without a support or without objects.
    """
    if segmentation.support is None or not clouds:
        return np.zeros((0, 3))
    step = max(frame.intrinsics.width // COLUMNS, 1)
    part = slice(None, None, step), slice(None, None, step)
    depth, labels = frame.depth[part], segmentation.labels[part]
    k = frame.intrinsics.reduced(step)
    rows, columns = np.arange(k.height)[:, None], np.arange(k.width)[None, :]
    near = cv2.dilate((labels > 0).astype(np.uint8), np.ones((2 * EDGE + 1,) * 2, np.uint8)) > 0
    free = (depth > 0) & ~near
    for number, plane in enumerate((segmentation.support, *segmentation.other_supports)):
        slope = plane.normal[0] * (columns - k.cx) / k.fx + plane.normal[2]
        height = depth * (slope + plane.normal[1] * (rows - k.cy) / k.fy) + plane.offset
        # Boards of a shelf lie above the first support, and things stand below them.
        height = np.abs(height) if number else height
        free &= height > max(MIN_HEIGHT, 3.0 * plane.tolerance)
    v, u = np.nonzero(free)
    counts = _weights(frame.depth, step * v, step * u)
    v, u = np.repeat(v, counts), np.repeat(u, counts)
    z = depth[v, u].astype(np.float64)
    points = T_scene_camera.apply(
        np.column_stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z])
    )
    objects = np.concatenate(clouds)
    low, high = objects.min(axis=0) - REACH, objects.max(axis=0) + REACH
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    return points[:: max(ceil(len(points) / MAX_POINTS), 1)]


def _weights(
    depth: NDArray[np.float32], v: NDArray[np.intp], u: NDArray[np.intp]
) -> NDArray[np.int64]:
    """Return how often readings at pixels (K,), (K,) count, (K,): 0 for those that mix depths."""
    padded, own = np.pad(depth, 1), depth[v, u]
    around = [(dv, du) for dv in (0, 1, 2) for du in (0, 1, 2) if (dv, du) != (1, 1)]
    neighbours = np.array([padded[v + dv, u + du] for dv, du in around])
    farther = neighbours - own
    alike = (np.abs(farther) < ALIKE * own).sum(axis=0)
    behind = ((neighbours > 0) & (farther < -ALIKE * own)).any(axis=0)
    thin = (alike >= MIN_ALIKE_FRONT) & ~behind
    return np.where(alike >= MIN_ALIKE, 1, np.where(thin, THIN_WEIGHT, 0))

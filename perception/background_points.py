"""Readings above the support that belong to no object: boards, walls, fixtures."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

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
    k = frame.intrinsics.reduced(step)
    planes = np.array(
        [
            (*plane.normal, plane.offset, max(MIN_HEIGHT, 3.0 * plane.tolerance))
            for plane in (segmentation.support, *segmentation.other_supports)
        ]
    )
    pinhole = (k.fx, k.fy, k.cx, k.cy)
    free = free_readings(frame.depth, segmentation.labels, step, planes, pinhole)
    points = T_scene_camera.apply(free)
    objects = np.concatenate(clouds)
    low, high = objects.min(axis=0) - REACH, objects.max(axis=0) + REACH
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    return points[:: max(ceil(len(points) / MAX_POINTS), 1)]


@njit(cache=True, nogil=True)
def free_readings(depth, labels, step, planes, pinhole):
    """Return the readings above all supports that no object is near, (K, 3), camera frame, m.

    Readings that mix depths are left out, and those of thin things are returned several times.

    Parameters
    ----------
    depth
        The whole image (H, W), m.
    labels
        Its objects (H, W).
    step
        Step of the rows and columns of the readings, px.
    planes
        Unit normals and offsets of the supports, and the least heights above them, (P, 5), m.
    pinhole
        fx, fy, cx, cy of the image of every `step`-th row and column.
    """
    fx, fy, cx, cy = pinhole
    rows, columns = -(-depth.shape[0] // step), -(-depth.shape[1] // step)
    points = np.empty((rows * columns * THIN_WEIGHT, 3))
    count = 0
    for v in range(rows):
        for u in range(columns):
            z = np.float64(depth[v * step, u * step])
            if z <= 0 or not _is_above(planes, z, (u - cx) / fx, (v - cy) / fy):
                continue
            if _is_near_object(labels, v, u, step):
                continue
            for _ in range(_weight(depth, v * step, u * step)):
                points[count, 0] = (u - cx) / fx * z
                points[count, 1] = (v - cy) / fy * z
                points[count, 2] = z
                count += 1
    return points[:count].copy()


@njit(cache=True, nogil=True)
def _is_above(planes, z, ray_u, ray_v):
    """Return whether a reading lies above the first plane and beside the others."""
    for k in range(len(planes)):
        a, b, c, offset, least = planes[k]
        height = z * (a * ray_u + b * ray_v + c) + offset
        # Boards of a shelf lie above the first support, and things stand below them.
        if (abs(height) if k else height) <= least:
            return False
    return True


@njit(cache=True, nogil=True)
def _is_near_object(labels, v, u, step):
    """Return whether an object is within EDGE of a pixel of every `step`-th row and column."""
    for y in range(max(v - EDGE, 0), v + EDGE + 1):
        for x in range(max(u - EDGE, 0), u + EDGE + 1):
            if (
                y * step < labels.shape[0]
                and x * step < labels.shape[1]
                and labels[y * step, x * step]
            ):
                return True
    return False


@njit(cache=True, nogil=True)
def _weight(depth, v, u):
    """Return how often the reading of a pixel counts: 0 if it mixes depths."""
    own = depth[v, u]
    limit = np.float32(ALIKE) * own
    alike, behind = 0, False
    for y in range(max(v - 1, 0), min(v + 2, depth.shape[0])):
        for x in range(max(u - 1, 0), min(u + 2, depth.shape[1])):
            if (y, x) == (v, u) or depth[y, x] <= 0:
                continue
            farther = depth[y, x] - own
            alike += abs(farther) < limit
            behind |= farther < -limit
    if alike >= MIN_ALIKE:
        return 1
    return THIN_WEIGHT if alike >= MIN_ALIKE_FRONT and not behind else 0

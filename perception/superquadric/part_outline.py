"""Planes through the camera that touch the outline of a part where nothing lies beside it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .work_rows import FAST_MATH

DIRECTIONS = 24
"""Directions in which the outline is touched."""
_ANGLES = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
_NORMALS = np.ascontiguousarray(np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]))


def outline_planes(
    image: NDArray[np.float64],
    in_part: NDArray[np.bool_],
    owner: NDArray[np.int64],
    unknown: NDArray[np.float64],
    frame: NDArray[np.float64],
    origin: NDArray[np.float64],
    margin: float,
    clearance: float,
) -> NDArray[np.float64]:
    """Return inward planes (J, 4) that touch the outline of a part and contain the camera.

    A plane is left out where another part, or an unknown region, continues beside the outline.

    Parameters
    ----------
    image
        (N, 2) positions of the object's points in the image plane at unit depth.
    in_part, owner
        (M,) mask of the points of the search that belong to the part, and (N,) the index of the
        point of the search whose part each point shares.
    unknown
        (M, 2) positions in the image where the object may continue unseen.
    frame
        (3, 3) rows: the axes of the image plane and the viewing direction.
    origin
        (3,) position of the camera.
    margin
        Distance of the planes from the outermost points in the image: half a pixel.
    clearance
        Distance beyond these points at which no other part and nothing unknown may lie.
    """
    heights, free = _touch(image, in_part, owner, unknown, _NORMALS, clearance)
    return _planes(heights, free, _NORMALS, frame, origin, margin)


@njit(cache=True, nogil=True, error_model="numpy")
def _planes(heights, free, normals, frame, origin, margin):
    """Return the planes (J, 4) of the free directions from the heights (K,) of the outline."""
    planes = np.zeros((np.count_nonzero(free), 4))
    row = 0
    for k in range(free.size):
        if not free[k]:
            continue
        height = heights[k] + margin
        size = np.sqrt(1.0 + height * height)
        for j in range(3):
            along = -normals[k, 0] * frame[0, j] - normals[k, 1] * frame[1, j]
            planes[row, j] = (along + height * frame[2, j]) / size
            planes[row, 3] -= planes[row, j] * origin[j]
        row += 1
    return planes


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _touch(image, in_part, owner, unknown, normals, clearance):
    """Return the heights (K,) of the outline along normals (K, 2), and whether it is free there."""
    count = normals.shape[0]
    heights, nearest = np.full(count, -1e300), np.full(count, 1e300)
    ends = np.zeros((2, count))
    for i in range(image.shape[0]):
        if not in_part[owner[i]]:
            continue
        for k in range(count):
            height = normals[k, 0] * image[i, 0] + normals[k, 1] * image[i, 1]
            if height > heights[k]:
                heights[k], ends[0, k], ends[1, k] = height, image[i, 0], image[i, 1]
    for k in range(count):
        ends[0, k] += clearance * normals[k, 0]
        ends[1, k] += clearance * normals[k, 1]
    for i in range(image.shape[0]):
        if not in_part[owner[i]]:
            _approach(image[i, 0], image[i, 1], ends, nearest)
    for i in range(unknown.shape[0]):
        _approach(unknown[i, 0], unknown[i, 1], ends, nearest)
    return heights, nearest >= clearance * clearance


# Without branches the loop takes several directions at a time.
@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _approach(x, y, ends, nearest):
    """Lower the squared distances (K,) of the nearest points from the ends (2, K) by a point."""
    for k in range(nearest.size):
        dx, dy = x - ends[0, k], y - ends[1, k]
        nearest[k] = min(nearest[k], dx * dx + dy * dy)

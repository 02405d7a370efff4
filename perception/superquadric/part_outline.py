"""Planes through the camera that touch the outline of a part where nothing lies beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

DIRECTIONS = 24
"""Directions in which the outline is touched."""
_ANGLES = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
_NORMALS = np.ascontiguousarray(np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]))


def outline_planes(
    image: NDArray[np.float64],
    in_part: NDArray[np.bool_],
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
    in_part
        (N,) mask of the points of the part.
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
    heights, free = _touch(image, in_part, unknown, _NORMALS, clearance)
    heights = heights[free] + margin
    local = np.column_stack([-_NORMALS[free], heights])
    normals = local / np.sqrt(1.0 + heights**2)[:, None] @ frame
    return np.column_stack([normals, -normals @ origin])


@njit(cache=True, nogil=True)
def _touch(image, in_part, unknown, normals, clearance):
    """Return the heights (K,) of the outline along normals (K, 2), and whether it is free there."""
    count = normals.shape[0]
    heights, free = np.full(count, -np.inf), np.ones(count, dtype=np.bool_)
    ends = np.zeros((count, 2))
    for i in range(image.shape[0]):
        if not in_part[i]:
            continue
        for k in range(count):
            height = normals[k, 0] * image[i, 0] + normals[k, 1] * image[i, 1]
            if height > heights[k]:
                heights[k], ends[k, 0], ends[k, 1] = height, image[i, 0], image[i, 1]
    ends += clearance * normals
    for i in range(image.shape[0]):
        if not in_part[i]:
            _mark_neighbours(image[i], ends, clearance, free)
    for i in range(unknown.shape[0]):
        _mark_neighbours(unknown[i], ends, clearance, free)
    return heights, free


@njit(cache=True, nogil=True)
def _mark_neighbours(point, ends, clearance, free):
    """Mark the ends (K, 2) within the clearance of a point (2,) as not free."""
    for k in range(ends.shape[0]):
        x, y = ends[k, 0] - point[0], ends[k, 1] - point[1]
        if x * x + y * y < clearance * clearance:
            free[k] = False

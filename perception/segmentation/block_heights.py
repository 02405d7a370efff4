"""The image as a landscape: the greatest height above a plane per block of pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .result import SupportPlane
    from .working_image import WorkingImage

BLOCK = 4
"""Side of the blocks whose highest reading counts, px. A rim of one pixel still closes."""
LOWEST = -1e6
"""Height of a block without readings, m."""


def block_heights(image: WorkingImage, plane: SupportPlane) -> NDArray[np.float32]:
    """Return the greatest height above a plane per block of an image, m; LOWEST = no reading."""
    k = image.intrinsics
    slope_u = (plane.normal[0] * (np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    slope_v = plane.normal[1] * (np.arange(k.height) - k.cy) / k.fy + plane.normal[2]
    return block_tops(
        image.depth,
        slope_u,
        slope_v.astype(np.float32),
        np.float32(plane.offset),
        image.length(BLOCK),
    )


@njit(cache=True, nogil=True)
def block_tops(depth, slope_u, slope_v, offset, side):
    """Return the greatest height per block of side x side px above a plane, m; LOWEST = no reading.

    The height of a reading of depth z is z (slope_u + slope_v) + offset.
    """
    rows, columns = depth.shape
    tops = np.full((-(-rows // side), -(-columns // side)), np.float32(LOWEST))
    row = np.empty(columns, np.float32)
    for k in range(len(tops)):
        row[:] = LOWEST
        for v in range(k * side, min((k + 1) * side, rows)):
            slope = slope_v[v]
            for u in range(columns):
                height = depth[v, u] * (slope_u[u] + slope) + offset
                height = height if depth[v, u] > 0 else np.float32(LOWEST)
                row[u] = max(row[u], height)
        for u in range(columns):
            tops[k, u // side] = max(tops[k, u // side], row[u])
    return tops

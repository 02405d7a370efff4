"""Smooth patches: connected pixels whose local planes continue each other."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .connected_parts import connected_parts
from .label_pixels import renumber_labels
from .local_planes import LocalPlanes, row_normals
from .working_image import WorkingImage

MIN_PATCH = 40
"""Minimum size of a patch, px at the reference width. A lower value keeps thin objects, a higher
one rejects clutter from noise."""
LINK_ANGLE = 0.14
"""Maximum angle between the planes of linked neighbours, rad. A lower value splits curved surfaces,
a higher one merges across shallow creases."""
LINK_SIGMAS = 3.0
"""Maximum distance of a plane from its neighbour's, in σ of disparity. A lower value splits noisy
surfaces, a higher one merges across small steps."""


def linked_pixels(image: WorkingImage, planes: LocalPlanes) -> NDArray[np.uint8]:
    """Mark pixels linked to their right and lower neighbours by 1, (H, W) uint8.

    Two neighbours are linked when their normals agree and each plane extrapolates to the other.
    """
    return links(
        planes,
        image.pinhole,
        np.float32(np.cos(LINK_ANGLE)),
        np.float32(LINK_SIGMAS * image.noise),
    )


def label_patches(linked: NDArray[np.uint8], min_patch: int) -> NDArray[np.int32]:
    """Label connected linked pixels (H, W): 1..n = patches of at least `min_patch` px, int32."""
    labels, sizes, _ = connected_parts(linked)
    keep = sizes >= min_patch
    keep[0] = False
    renumber = np.zeros(len(sizes), np.int32)
    renumber[keep] = np.arange(1, np.count_nonzero(keep) + 1, dtype=np.int32)
    return renumber_labels(labels, renumber)


@njit(cache=True, nogil=True)
def links(planes, pinhole, min_cosine, max_gap):
    """Compute :func:`linked_pixels` from fx, fy, cx, cy, px, and thresholds."""
    rows, columns = planes.value.shape
    linked = np.zeros((rows, columns), np.uint8)
    u_from_centre = np.arange(columns) - pinhole[2]
    here, below = np.empty((3, columns), np.float32), np.empty((3, columns), np.float32)
    if rows:
        row_normals(planes, 0, pinhole, u_from_centre, here)
    for v in range(rows - 1):
        row_normals(planes, v + 1, pinhole, u_from_centre, below)
        _link_row(planes, v, (here, below), (min_cosine, max_gap), linked[v])
        here, below = below, here
    return linked


@njit(cache=True, nogil=True)
def _link_row(planes, v, normals, limits, linked):
    """Mark the linked pixels of row v from the normals (3, W) of this and the next row."""
    min_cosine, max_gap = limits
    value, slope_u, slope_v = planes.value[v], planes.slope_u[v], planes.slope_v[v]
    next_value, next_slope_v = planes.value[v + 1], planes.slope_v[v + 1]
    x, y, z = normals[0][0], normals[0][1], normals[0][2]
    next_x, next_y, next_z = normals[1][0], normals[1][1], normals[1][2]
    # Without branches the compiler handles several pixels at once.
    for u in range(len(value) - 1):
        q, right, below = value[u], value[u + 1], next_value[u]
        known = (q > 0) & (right > 0) & (below > 0)
        known &= (abs(q + slope_u[u] - right) <= max_gap) & (
            abs(right - slope_u[u + 1] - q) <= max_gap
        )
        known &= (abs(q + slope_v[u] - below) <= max_gap) & (
            abs(below - next_slope_v[u] - q) <= max_gap
        )
        across = x[u] * x[u + 1] + y[u] * y[u + 1] + z[u] * z[u + 1]
        down = x[u] * next_x[u] + y[u] * next_y[u] + z[u] * next_z[u]
        linked[u] = known & (across >= min_cosine) & (down >= min_cosine)

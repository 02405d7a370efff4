"""Smooth patches: connected pixels whose local planes continue each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .connected_parts import connected_parts
from .local_planes import plane_normals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
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
        plane_normals(planes, image.intrinsics),
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
    return np.take(renumber, labels)


@njit(cache=True, nogil=True)
def links(planes, normals, min_cosine, max_gap):
    """Compute :func:`linked_pixels` from normals (H, W, 3) and thresholds."""
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    rows, columns = value.shape
    linked = np.zeros((rows, columns), np.uint8)
    for v in range(rows - 1):
        for u in range(columns - 1):
            q = value[v, u]
            if q <= 0:
                continue
            right, below = value[v, u + 1], value[v + 1, u]
            if right <= 0 or below <= 0:
                continue
            if (
                abs(q + slope_u[v, u] - right) > max_gap
                or abs(right - slope_u[v, u + 1] - q) > max_gap
                or abs(q + slope_v[v, u] - below) > max_gap
                or abs(below - slope_v[v + 1, u] - q) > max_gap
            ):
                continue
            across = down = np.float32(0.0)
            for k in range(3):
                across += normals[v, u, k] * normals[v, u + 1, k]
                down += normals[v, u, k] * normals[v + 1, u, k]
            if across >= min_cosine and down >= min_cosine:
                linked[v, u] = 1
    return linked

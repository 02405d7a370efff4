"""Smooth patches: pixels whose local planes continue one another."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes
    from .options import SegmentationOptions


def linked_pixels(
    planes: LocalPlanes, normals: NDArray[np.float32], options: SegmentationOptions
) -> NDArray[np.uint8]:
    """1 where a pixel continues into its right and lower neighbours, (H, W) uint8.

    Two neighbours are linked when their normals agree and each plane extrapolates to the other.
    """
    return links(
        planes.value,
        planes.slope_u,
        planes.slope_v,
        normals,
        np.float32(np.cos(options.link_angle)),
        np.float32(options.link_sigmas * planes.noise),
    )


def smooth_patches(linked: NDArray[np.uint8], min_patch: int) -> NDArray[np.int32]:
    """Label connected linked pixels, (H, W) int32: 1..n = patches of at least min_patch px."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(linked, connectivity=4)
    keep = stats[:, cv2.CC_STAT_AREA] >= min_patch
    keep[0] = False
    renumber = np.zeros(count, np.int32)
    renumber[keep] = np.arange(1, np.count_nonzero(keep) + 1, dtype=np.int32)
    return np.take(renumber, np.asarray(labels, dtype=np.int32))


def plane_normals(planes: LocalPlanes, camera: CameraIntrinsics) -> NDArray[np.float32]:
    """Unit normals towards the camera, (H, W, 3) float32; zero where there is no plane.

    A plane n·X = 1 has q = n·(x/z, y/z, 1), so slopes and value give n without any neighbour.
    """
    return _normals(
        planes.value, planes.slope_u, planes.slope_v, camera.fx, camera.fy, camera.cx, camera.cy
    )


@njit(cache=True, nogil=True)
def _normals(value, slope_u, slope_v, fx, fy, cx, cy):
    rows, columns = value.shape
    normals = np.zeros((rows, columns, 3), np.float32)
    for v in range(rows):
        for u in range(columns):
            if value[v, u] <= 0:
                continue
            x, y = slope_u[v, u] * fx, slope_v[v, u] * fy
            z = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
            scale = -1.0 / np.sqrt(x * x + y * y + z * z)
            normals[v, u, 0] = x * scale
            normals[v, u, 1] = y * scale
            normals[v, u, 2] = z * scale
    return normals


@njit(cache=True, nogil=True)
def links(value, slope_u, slope_v, normals, min_cosine, max_gap):
    """Links of all pixels; see :func:`linked_pixels`."""
    rows, columns = value.shape
    inner = np.zeros((rows, columns), np.uint8)
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
                inner[v, u] = 1
    return inner

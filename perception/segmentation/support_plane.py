"""The plane that carries the objects, from planes that single pixels already know."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

from ..frame import CameraIntrinsics
from ..perpendicular import perpendicular_pair
from .local_planes import LocalPlanes, plane_sums
from .result import SupportPlane
from .smooth_patches import plane_normals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import DepthFrame
    from .options import SegmentationOptions

SAMPLES = 2000
"""Pixels on which candidate planes are scored; more ranks similar planes better."""
COARSE_WIDTH = 160
"""Columns of the reduced image on which hypotheses are fitted."""
COARSE_RADIUS = 4
"""Half side of their windows, reduced px."""
COARSE_NOISE = 2.5
"""Largest residual of a hypothesis' window, in σ: larger lets bent surfaces vote."""
NEAREST_SHARE = 0.6
"""Readings nearer than this share of the median depth weigh no more than those at it."""
MIN_INLIERS = 12
"""Fewer samples than this determine no plane."""
MIN_COSINE = 0.95
"""Agreement of normals for a pixel to speak for a candidate plane."""
REFITS = 3
"""Least-squares refits of the winner, each on the inliers of the last."""
MIN_SHARE = 0.03
"""Least share of the readings that a support plane must explain."""
BEND_BANDS = 8.0
"""How many bands below the plane a surface that bends away from it still is next to it."""
BEND_MAX_SHARE = 0.15
"""A plane with a larger share of the image is a support even if its far end is wavy."""
BEND_SHARE = 0.5
"""Share of a plane's surroundings that bend away for it to be the top of a curved surface."""
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


class Support(NamedTuple):
    """The support plane and where in the image it was seen."""

    plane: SupportPlane
    height: NDArray[np.float32]
    """Height of every reading above the plane, (H, W), m; -inf = no reading."""
    hull: NDArray[np.float32]
    """Convex hull of the plane's largest connected part, in plane coordinates, (K, 2), m."""
    axes: NDArray[np.float64]
    """Plane coordinate axes as rows, (2, 3)."""
    depth: float
    """Median depth at which the plane's spread was measured, m."""


def find_support(
    frame: DepthFrame,
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    options: SegmentationOptions,
) -> Support | None:
    """Find the support plane by one-point RANSAC (a pixel with its local plane is a hypothesis).

    The hypotheses are planes fitted to wide windows on every few pixels: a support is large, and
    the wider the window the surer its normal. Where clutter leaves no window that wide, the
    pixels' own planes take their place. With the camera's place known only planes within
    ``max_tilt`` of horizontal count. The plane with the most readings wins, near ones weighing
    more. The sampling grid is fixed, so equal frames give equal planes.
    """
    stride = max(frame.intrinsics.width // COARSE_WIDTH, 1)
    wide = plane_sums(np.ascontiguousarray(disparity[::stride, ::stride]), COARSE_RADIUS, 0.5)
    found = _vote(frame, LocalPlanes(*wide, planes.noise), stride, options)
    if found is None and stride > 1:
        found = _vote(frame, planes, 1, options)
    return None if found is None else _locate(*found, frame, planes.noise, options)


def _vote(
    frame: DepthFrame, planes: LocalPlanes, stride: int, options: SegmentationOptions
) -> tuple[SupportPlane, float] | None:
    """Best plane among those of every `stride`-th pixel, and the median depth of its readings."""
    noise = planes.noise
    normals = plane_normals(planes, _reduced(frame.intrinsics, stride))
    smooth = (planes.rms >= 0) & (planes.rms < COARSE_NOISE * noise)
    rows, columns = np.nonzero(smooth)
    if rows.size == 0:
        return None
    step = max(rows.size // SAMPLES, 1)
    rows, columns = rows[::step], columns[::step]
    sample_normals = normals[rows, columns].astype(np.float64)
    rows, columns = rows * stride, columns * stride
    k = frame.intrinsics
    z = frame.depth[rows, columns].astype(np.float64)
    rays = np.column_stack([(columns - k.cx) / k.fx, (rows - k.cy) / k.fy, np.ones(rows.size)])
    sample_points = rays * z[:, None]

    chosen = np.arange(0, rows.size, max(rows.size // options.plane_candidates, 1))
    candidates = sample_normals[chosen]
    if frame.T_world_camera is not None:
        up = frame.T_world_camera.rotation.inv().apply([0.0, 0.0, 1.0])
        level = candidates @ up >= np.cos(options.max_tilt)
        chosen, candidates = chosen[level], candidates[level]
    if chosen.size == 0:
        return None
    offsets = -np.einsum("ij,ij->i", candidates, sample_points[chosen])
    # A height h over the plane n·X + d = 0 is a disparity residual of h / (z |d|).
    gaps = np.abs(candidates @ rays.T / offsets[:, None] + (1.0 / z))
    votes = gaps < options.plane_sigmas * noise
    votes &= candidates @ sample_normals.T > MIN_COSINE
    # Weighing by squared disparity prefers the table at hand to a floor that fills more pixels;
    # the cap keeps a gripper before the lens from outweighing both.
    nearest = NEAREST_SHARE * float(np.median(z))
    best = int(np.argmax(votes @ (1.0 / np.maximum(z, nearest) ** 2)))
    inlier = votes[best]
    if inlier.sum() < MIN_SHARE * rows.size:
        return None

    q = 1.0 / z
    n = -candidates[best] / offsets[best]
    for _ in range(REFITS):
        n, *_ = np.linalg.lstsq(rays[inlier], q[inlier], rcond=None)
        inlier = np.abs(rays @ n - q) < options.plane_sigmas * noise
        if np.count_nonzero(inlier) < MIN_INLIERS:
            return None
    length = np.linalg.norm(n)
    plane_normal, offset = -n / length, 1.0 / length
    spread = np.abs(sample_points[inlier] @ plane_normal + offset)
    plane = SupportPlane(plane_normal, float(offset), float(MAD_TO_SIGMA * np.median(spread)))
    return plane, float(np.median(z[inlier]))


def _reduced(camera: CameraIntrinsics, stride: int) -> CameraIntrinsics:
    """Give the camera of every `stride`-th pixel."""
    return CameraIntrinsics(
        camera.fx / stride,
        camera.fy / stride,
        camera.cx / stride,
        camera.cy / stride,
        -(-camera.width // stride),
        -(-camera.height // stride),
    )


def _locate(
    plane: SupportPlane,
    depth: float,
    frame: DepthFrame,
    noise: float,
    options: SegmentationOptions,
) -> Support | None:
    # Per pixel the height is depth * (n·ray) + offset, and n·ray is linear in the pixel.
    k = frame.intrinsics
    nx, ny, nz = plane.normal
    ray_u = (nx * (np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    ray_v = (ny * (np.arange(k.height) - k.cy) / k.fy + nz).astype(np.float32)
    height = frame.depth * (ray_u[None, :] + ray_v[:, None]) + np.float32(plane.offset)
    band = frame.depth * np.float32(options.plane_sigmas * noise * abs(plane.offset))
    band = np.maximum(band, np.float32(options.plane_sigmas * plane.tolerance))
    inliers = frame.valid & (np.abs(height) < band)
    height[~frame.valid] = -np.inf
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        inliers.astype(np.uint8), connectivity=4
    )
    if count < 2:
        return None
    largest = labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    small = np.count_nonzero(largest) < BEND_MAX_SHARE * largest.size
    if small and _bends_away(largest, height, band):
        return None
    axes = perpendicular_pair(plane.normal)
    return Support(plane, height, _hull(largest, plane, frame, axes), axes, depth)


def _bends_away(
    plane: NDArray[np.bool_], height: NDArray[np.float32], band: NDArray[np.float32]
) -> bool:
    """Whether the surface goes on below the plane all around: the top of a ball, no support."""
    ring = cv2.dilate(plane.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    ring &= ~plane & np.isfinite(height)
    below = ring & (height < 0) & (height > -BEND_BANDS * band)
    return bool(np.count_nonzero(below) > BEND_SHARE * max(np.count_nonzero(ring), 1))


def _hull(
    mask: NDArray[np.bool_], plane: SupportPlane, frame: DepthFrame, axes: NDArray[np.float64]
) -> NDArray[np.float32]:
    # A projection keeps convexity, so the image's few hull pixels give the hull on the plane.
    outlines, _ = cv2.findContours(
        mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    pixels = cv2.convexHull(np.concatenate(outlines)).reshape(-1, 2)
    k = frame.intrinsics
    rays = np.column_stack(
        [(pixels[:, 0] - k.cx) / k.fx, (pixels[:, 1] - k.cy) / k.fy, np.ones(len(pixels))]
    )
    on_plane = rays * (-plane.offset / (rays @ plane.normal))[:, None]
    return (on_plane @ axes.T).astype(np.float32)

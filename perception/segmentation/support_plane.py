"""Detection of the planes that objects stand on."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from ..perpendicular import perpendicular_pair
from .above_support import SUPPORT_SIGMAS
from .local_planes import MIN_WINDOW_SHARE, LocalPlanes, fit_centred_windows, plane_normals
from .result import SupportPlane

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions
    from .working_image import WorkingImage

CANDIDATES = 120
"""Planes that are tried as the support. More find smaller tables and take longer."""
SAMPLES = 2000
"""Pixels on which candidate planes are scored. More rank similar planes more reliably."""
COARSE_WIDTH = 160
"""Columns of the reduced image on which hypotheses are fitted."""
COARSE_RADIUS = 4
"""Half side of the windows in that image, px."""
COARSE_SHARE = 0.5
"""Minimum share of such a window's pixels with readings."""
COARSE_SIGMAS = 2.5
"""Maximum residual of a hypothesis' window, in σ. A larger one is a curved surface."""
LOCATE_WIDTH = 320
"""Columns of the reduced image in which the plane's outline is found."""
MAX_SUPPORTS = 4
"""Maximum number of supports."""
MIN_DISTANCE = 0.02
"""Minimum distance between two supports, m."""
MIN_AREA = 0.15
"""Minimum visible area of a further support, m². Smaller parallel planes are faces of objects."""
MAX_TILT = 0.35
"""Maximum angle between the normal and the vertical where the camera's pose is known, rad."""
HEIGHT_TOLERANCE = 0.05
"""Maximum distance of a support from the known height of the table, m."""
NEAR_SHARE = 0.6
"""Readings nearer than this share of the median depth weigh no more than those at it. Otherwise a
gripper in front of the lens would outweigh the table."""
MIN_INLIERS = 12
"""Minimum number of samples that determine a plane."""
MIN_COSINE = 0.95
"""Minimum cosine between the normals of a sample and of its plane."""
REFITS = 3
"""Least-squares fits of the best plane, each to the inliers of the one before."""
MIN_SHARE = 0.03
"""Minimum share of the samples that are inliers of a support."""
BEND_BANDS = 8.0
"""Depth below a plane, in bands, up to which a surface beside it counts as its continuation."""
BEND_MAX_SHARE = 0.15
"""Share of the image above which a plane is a support even if its edge bends away."""
BEND_SHARE = 0.5
"""Minimum share of a plane's surroundings that bend away when it is the top of a round object."""
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


class Support(NamedTuple):
    """A plane that objects may stand on, and its visible part."""

    plane: SupportPlane
    """The plane, camera frame."""
    hull: NDArray[np.float32]
    """Convex hull of the plane's largest connected part, in plan coordinates, (K, 2), m."""
    axes: NDArray[np.float64]
    """Axes of the plan coordinates as rows, (2, 3), camera frame."""
    depth: float
    """Median depth at which the scatter of the plane was measured, m."""


class PlaneSamples(NamedTuple):
    """Readings on which candidate planes are scored."""

    disparity: NDArray[np.float64]
    """(N,), 1/m."""
    rays: NDArray[np.float64]
    """Directions with z = 1, (N, 3)."""
    normals: NDArray[np.float64]
    """Unit normals of their local planes, (N, 3)."""
    weights: NDArray[np.float64]
    """(N,), 1/m²; 0 = explained by an earlier plane."""


def find_supports(image: WorkingImage, options: SegmentationOptions) -> list[Support]:
    """Detect the support planes by RANSAC in which one pixel's local plane is a hypothesis.

    The hypotheses come from wide windows on a reduced image. A support is large, and a wider
    window gives a more accurate normal. If no window is flat enough, the pixels' own planes are
    used.

    The plane with the largest weight of inliers is the first support. If the camera's pose is
    known, a support must be horizontal within ``MAX_TILT``. With ``table_height`` it must also
    lie at that height. Parallel planes of at least ``MIN_AREA`` are further supports, such as a
    shelf or the floor beside a table. The samples lie on a fixed grid, so equal frames give equal
    planes.

    Returns
    -------
    list of Support
        The best one first; empty when no plane is found.
    """
    stride = max(image.intrinsics.width // COARSE_WIDTH, 1)
    coarse = np.ascontiguousarray(image.disparity[::stride, ::stride])
    planes = LocalPlanes(*fit_centred_windows(coarse, COARSE_RADIUS, COARSE_SHARE))
    detected = _detect_planes(image, planes, stride, options.table_height)
    if not detected and stride > 1:
        radius = options.window // 2
        planes = LocalPlanes(*fit_centred_windows(image.disparity, radius, MIN_WINDOW_SHARE))
        detected = _detect_planes(image, planes, 1, options.table_height)
    supports = [
        support
        for k, (plane, depth) in enumerate(detected)
        if (support := _locate(plane, depth, k > 0, image)) is not None
    ]
    return supports if detected and supports and supports[0].plane is detected[0][0] else []


def _detect_planes(
    image: WorkingImage, planes: LocalPlanes, stride: int, table_height: float | None
) -> list[tuple[SupportPlane, float]]:
    """Return the planes with the most inliers and the median depths of these, best first."""
    normals = plane_normals(planes, image.intrinsics.reduced(stride))
    flat = (planes.rms >= 0) & (planes.rms < COARSE_SIGMAS * image.noise)
    rows, columns = np.nonzero(flat)
    if rows.size == 0:
        return []
    step = max(rows.size // SAMPLES, 1)
    rows, columns = rows[::step], columns[::step]
    sample_normals = normals[rows, columns].astype(np.float64)
    rows, columns = rows * stride, columns * stride
    k = image.intrinsics
    z = image.depth[rows, columns].astype(np.float64)
    rays = np.ones((rows.size, 3))
    rays[:, 0], rays[:, 1] = (columns - k.cx) / k.fx, (rows - k.cy) / k.fy
    points = rays * z[:, None]

    tried = np.arange(0, rows.size, max(rows.size // CANDIDATES, 1))
    tried = tried[_is_plausible(points[tried], sample_normals[tried], image, table_height)]
    if tried.size == 0:
        return []
    candidates = sample_normals[tried]
    offsets = -np.einsum("ij,ij->i", candidates, points[tried])
    # The weight of squared disparity prefers the table to a floor that fills more pixels.
    weights = 1.0 / np.maximum(z, NEAR_SHARE * float(np.median(z))) ** 2
    detected: list[tuple[SupportPlane, float]] = []
    free = np.ones(rows.size, bool)
    tolerance = SUPPORT_SIGMAS * image.noise
    while len(detected) < MAX_SUPPORTS:
        samples = PlaneSamples(1.0 / z, rays, sample_normals, weights * free)
        best = int(np.argmax(plane_scores(candidates, offsets, samples, tolerance)))
        inliers = plane_inliers(candidates[best], offsets[best], samples, tolerance)
        if inliers.sum() < MIN_SHARE * rows.size:
            break
        free &= ~inliers
        fitted = _refit(-candidates[best] / offsets[best], rays, z, inliers, tolerance)
        if fitted is None:
            break
        plane, inliers = fitted
        # Each sample represents the same number of pixels, and a pixel at z the area (z / f)².
        share = step * stride**2 / (k.fx * k.fy)
        slant = np.abs(rays @ plane.normal)[inliers]
        area = float((share * z[inliers] ** 2 / np.maximum(slant, 1e-3)).sum())
        parallel = not detected or abs(float(plane.normal @ detected[0][0].normal)) > MIN_COSINE
        if parallel and (not detected or area >= MIN_AREA):
            detected.append((plane, float(np.median(z[inliers]))))
        elif not detected:
            break
        # Remove the whole neighbourhood of the plane, so that its edge does not win next.
        free &= np.abs(points @ plane.normal + plane.offset) > MIN_DISTANCE
        remaining = np.abs(candidates @ detected[0][0].normal) > MIN_COSINE
        candidates, offsets = candidates[remaining], offsets[remaining]
        if not len(candidates):
            break
    return detected


def _is_plausible(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    image: WorkingImage,
    table_height: float | None,
) -> NDArray[np.bool_]:
    """Mark the horizontal planes at the known height; all planes if the pose is unknown."""
    if image.T_world_camera is None:
        return np.ones(len(points), bool)
    up = image.T_world_camera.rotation.inv().apply([0.0, 0.0, 1.0])
    plausible = normals @ up >= np.cos(MAX_TILT)
    if table_height is not None:
        height = image.T_world_camera.apply(points)[:, 2]
        plausible &= np.abs(height - table_height) <= HEIGHT_TOLERANCE
    return plausible


def _refit(
    n: NDArray[np.floating],
    rays: NDArray[np.float64],
    z: NDArray[np.float64],
    inliers: NDArray[np.bool_],
    tolerance: float,
) -> tuple[SupportPlane, NDArray[np.bool_]] | None:
    """Fit the plane n·X = 1 to its inliers; return it and its new inliers, None if too few."""
    q = 1.0 / z
    for _ in range(REFITS):
        n, *_ = np.linalg.lstsq(rays[inliers], q[inliers], rcond=None)
        inliers = np.abs(rays @ n - q) < tolerance
        if np.count_nonzero(inliers) < MIN_INLIERS:
            return None
    length = np.linalg.norm(n)
    normal, offset = -n / length, 1.0 / length
    heights = np.abs((rays[inliers] * z[inliers, None]) @ normal + offset)
    return SupportPlane(normal, float(offset), float(MAD_TO_SIGMA * np.median(heights))), inliers


def _locate(
    plane: SupportPlane, depth: float, further: bool, image: WorkingImage
) -> Support | None:
    """Find the visible part of a plane; None if there is none, or if it is a round object's top."""
    stride = max(image.intrinsics.width // LOCATE_WIDTH, 1)
    k = image.intrinsics.reduced(stride)
    z = np.ascontiguousarray(image.depth[::stride, ::stride])
    # The height of a pixel is depth * (n·ray) + offset, and n·ray is linear in its coordinates.
    nx, ny, nz = plane.normal
    ray_u = (nx * (np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    ray_v = (ny * (np.arange(k.height) - k.cy) / k.fy + nz).astype(np.float32)
    height = z * (ray_u[None, :] + ray_v[:, None]) + np.float32(plane.offset)
    band = z * np.float32(SUPPORT_SIGMAS * image.noise * abs(plane.offset))
    band = np.maximum(band, np.float32(SUPPORT_SIGMAS * plane.tolerance))
    inliers = (z > 0) & (np.abs(height) < band)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        inliers.astype(np.uint8), connectivity=4
    )
    if count < 2:
        return None
    largest = labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    small = np.count_nonzero(largest) < BEND_MAX_SHARE * largest.size
    height[z <= 0] = -np.inf
    if small and not further and _bends_away(largest, height, band):
        return None
    axes = perpendicular_pair(plane.normal)
    return Support(plane, _hull(largest, plane, k, axes), axes, depth)


def _bends_away(
    plane: NDArray[np.bool_], height: NDArray[np.float32], band: NDArray[np.float32]
) -> bool:
    """Return whether the surface continues below the plane all around, as on top of a ball."""
    ring = cv2.dilate(plane.astype(np.uint8), np.ones((5, 5), np.uint8)).astype(bool)
    ring &= ~plane & np.isfinite(height)
    below = ring & (height < 0) & (height > -BEND_BANDS * band)
    return bool(np.count_nonzero(below) > BEND_SHARE * max(np.count_nonzero(ring), 1))


def _hull(
    mask: NDArray[np.bool_],
    plane: SupportPlane,
    k: CameraIntrinsics,
    axes: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Return the hull of a mask in plan coordinates, from the mask's hull in the image.

    This is exact because a projection keeps convexity.
    """
    outlines, _ = cv2.findContours(
        mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    pixels = cv2.convexHull(np.concatenate(outlines)).reshape(-1, 2)
    rays = np.column_stack(
        [(pixels[:, 0] - k.cx) / k.fx, (pixels[:, 1] - k.cy) / k.fy, np.ones(len(pixels))]
    )
    on_plane = rays * (-plane.offset / (rays @ plane.normal))[:, None]
    return (on_plane @ axes.T).astype(np.float32)


@njit(cache=True, nogil=True)
def plane_scores(candidates, offsets, samples, tolerance):
    """Return the weight of the inliers of each plane: candidates (C, 3), offsets (C,)."""
    q, rays, normals, weights = samples
    scores = np.zeros(len(candidates))
    for k in range(len(candidates)):
        a, b, c = candidates[k, 0], candidates[k, 1], candidates[k, 2]
        scale = 1.0 / offsets[k]
        for i in range(len(q)):
            # A height h over the plane n·X + d = 0 is a disparity residual of h / (z |d|).
            along = a * rays[i, 0] + b * rays[i, 1] + c * rays[i, 2]
            if abs(along * scale + q[i]) < tolerance:
                cosine = a * normals[i, 0] + b * normals[i, 1] + c * normals[i, 2]
                if cosine > MIN_COSINE:
                    scores[k] += weights[i]
    return scores


def plane_inliers(
    candidate: NDArray[np.float64], offset: float, samples: PlaneSamples, tolerance: float
) -> NDArray[np.bool_]:
    """Mark the samples of weight > 0 that are on a plane and have its normal, (N,) bool."""
    near = np.abs(samples.rays @ candidate / offset + samples.disparity) < tolerance
    return near & (samples.normals @ candidate > MIN_COSINE) & (samples.weights > 0)

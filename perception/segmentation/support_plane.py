"""The planes that carry objects, from planes that single pixels already know."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from ..perpendicular import perpendicular_pair
from .local_planes import MIN_WINDOW_SHARE, LocalPlanes, plane_sums
from .result import SupportPlane
from .smooth_patches import plane_normals

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions
    from .working_image import View

SAMPLES = 2000
"""Pixels on which candidate planes are scored; more ranks similar planes better."""
COARSE_WIDTH = 160
"""Columns of the reduced image on which hypotheses are fitted."""
COARSE_RADIUS = 4
"""Half side of their windows, reduced px."""
WIDE_SHARE = 0.5
"""Least share of a wide window with readings."""
LOCATE_WIDTH = 320
"""Columns of the reduced image in which the plane's outline is found."""
MAX_SUPPORTS = 4
"""Planes looked for; more than a few shelves no camera sees."""
APART = 0.02
"""Least distance between two supports, m."""
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
    """A plane that objects may stand on, and where it was seen."""

    plane: SupportPlane
    """The plane, camera frame."""
    hull: NDArray[np.float32]
    """Convex hull of the plane's largest connected part, in plane coordinates, (K, 2), m."""
    axes: NDArray[np.float64]
    """Plane coordinate axes as rows, (2, 3)."""
    depth: float
    """Median depth at which the plane's spread was measured, m."""


def find_supports(
    view: View,
    noise: float,
    options: SegmentationOptions,
) -> list[Support]:
    """Find the support plane by one-point RANSAC (a pixel with its local plane is a hypothesis).

    The hypotheses are planes fitted to wide windows on every few pixels: a support is large, and
    the wider the window the surer its normal. Where clutter leaves no window that wide, the
    pixels' own planes take their place. With the camera's place known only planes within
    ``max_tilt`` of horizontal count, and with ``table_height`` only those at that height. The
    plane with the most readings wins, near ones weighing more. Parallel planes too large to be
    the face of an object (``min_table``) are supports as well: a shelf, or the floor beside a
    table. The sampling grid is fixed, so equal frames give equal planes.

    Returns
    -------
    list
        The winner first; empty when nothing carries.
    """
    stride = max(view.intrinsics.width // COARSE_WIDTH, 1)
    coarse = np.ascontiguousarray(view.disparity[::stride, ::stride])
    wide = LocalPlanes(*plane_sums(coarse, COARSE_RADIUS, WIDE_SHARE), noise)
    found = _vote(view, wide, stride, options)
    if not found and stride > 1:
        radius = options.window // 2
        own = LocalPlanes(*plane_sums(view.disparity, radius, MIN_WINDOW_SHARE), noise)
        found = _vote(view, own, 1, options)
    supports = [
        support
        for k, (plane, depth) in enumerate(found)
        if (support := _locate(plane, depth, k > 0, view, noise, options)) is not None
    ]
    return supports if found and supports and supports[0].plane is found[0][0] else []


def _vote(
    view: View,
    planes: LocalPlanes,
    stride: int,
    options: SegmentationOptions,
) -> list[tuple[SupportPlane, float]]:
    """Planes that explain most, and the median depths of their readings, best first."""
    noise = planes.noise
    normals = plane_normals(planes, view.intrinsics.reduced(stride))
    smooth = (planes.rms >= 0) & (planes.rms < COARSE_NOISE * noise)
    rows, columns = np.nonzero(smooth)
    if rows.size == 0:
        return []
    step = max(rows.size // SAMPLES, 1)
    rows, columns = rows[::step], columns[::step]
    sample_normals = normals[rows, columns].astype(np.float64)
    rows, columns = rows * stride, columns * stride
    k = view.intrinsics
    z = view.depth[rows, columns].astype(np.float64)
    rays = np.ones((rows.size, 3))
    rays[:, 0], rays[:, 1] = (columns - k.cx) / k.fx, (rows - k.cy) / k.fy
    points = rays * z[:, None]

    chosen = np.arange(0, rows.size, max(rows.size // options.plane_candidates, 1))
    chosen = chosen[_plausible(points[chosen], sample_normals[chosen], view, options)]
    if chosen.size == 0:
        return []
    candidates = sample_normals[chosen]
    offsets = -np.einsum("ij,ij->i", candidates, points[chosen])
    # Weighing by squared disparity prefers the table at hand to a floor that fills more pixels;
    # the cap keeps a gripper before the lens from outweighing both.
    nearest = NEAREST_SHARE * float(np.median(z))
    weights = 1.0 / np.maximum(z, nearest) ** 2
    found: list[tuple[SupportPlane, float]] = []
    free = np.ones(rows.size, bool)
    tolerance = options.plane_sigmas * noise
    while len(found) < MAX_SUPPORTS:
        votes = (1.0 / z, rays, sample_normals, weights * free)
        scores = plane_scores(candidates, offsets, *votes, tolerance)
        best = int(np.argmax(scores))
        inlier = plane_inliers(
            candidates[best], offsets[best], *votes, options.plane_sigmas * noise
        )
        if inlier.sum() < MIN_SHARE * rows.size:
            break
        # Whatever the refit makes of them, these readings have had their say.
        free &= ~inlier
        fitted = _refit(-candidates[best] / offsets[best], rays, z, inlier, noise, options)
        if fitted is None:
            break
        plane, inlier = fitted
        # Each sample stands for as many pixels as any other, and a pixel at z for (z / f)².
        share = step * stride**2 / (k.fx * k.fy)
        slant = np.abs(rays @ plane.normal)[inlier]
        area = float((share * z[inlier] ** 2 / np.maximum(slant, 1e-3)).sum())
        level = not found or abs(float(plane.normal @ found[0][0].normal)) > MIN_COSINE
        if level and (not found or area >= options.min_table):
            found.append((plane, float(np.median(z[inlier]))))
        elif not found:
            break
        # The same surface must not win twice: its edge of the band goes with it.
        free &= np.abs(points @ plane.normal + plane.offset) > APART
        parallel = np.abs(candidates @ found[0][0].normal) > MIN_COSINE
        candidates, offsets = candidates[parallel], offsets[parallel]
        if not len(candidates):
            break
    return found


def _plausible(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    view: View,
    options: SegmentationOptions,
) -> NDArray[np.bool_]:
    """Which planes may carry something, by what is known of the camera's place."""
    if view.T_world_camera is None:
        return np.ones(len(points), bool)
    up = view.T_world_camera.rotation.inv().apply([0.0, 0.0, 1.0])
    plausible = normals @ up >= np.cos(options.max_tilt)
    if options.table_height is not None:
        height = view.T_world_camera.apply(points)[:, 2]
        plausible &= np.abs(height - options.table_height) <= options.table_tolerance
    return plausible


def _refit(
    n: NDArray[np.floating],
    rays: NDArray[np.float64],
    z: NDArray[np.float64],
    inlier: NDArray[np.bool_],
    noise: float,
    options: SegmentationOptions,
) -> tuple[SupportPlane, NDArray[np.bool_]] | None:
    q = 1.0 / z
    for _ in range(REFITS):
        n, *_ = np.linalg.lstsq(rays[inlier], q[inlier], rcond=None)
        inlier = np.abs(rays @ n - q) < options.plane_sigmas * noise
        if np.count_nonzero(inlier) < MIN_INLIERS:
            return None
    length = np.linalg.norm(n)
    normal, offset = -n / length, 1.0 / length
    spread = np.abs((rays[inlier] * z[inlier, None]) @ normal + offset)
    return SupportPlane(normal, float(offset), float(MAD_TO_SIGMA * np.median(spread))), inlier


def _locate(
    plane: SupportPlane,
    depth: float,
    extra: bool,
    view: View,
    noise: float,
    options: SegmentationOptions,
) -> Support | None:
    """Find the plane's part of the image, on every few pixels."""
    stride = max(view.intrinsics.width // LOCATE_WIDTH, 1)
    k = view.intrinsics.reduced(stride)
    z = np.ascontiguousarray(view.depth[::stride, ::stride])
    # Per pixel the height is depth * (n·ray) + offset, and n·ray is linear in the pixel.
    nx, ny, nz = plane.normal
    ray_u = (nx * (np.arange(k.width) - k.cx) / k.fx).astype(np.float32)
    ray_v = (ny * (np.arange(k.height) - k.cy) / k.fy + nz).astype(np.float32)
    height = z * (ray_u[None, :] + ray_v[:, None]) + np.float32(plane.offset)
    band = z * np.float32(options.plane_sigmas * noise * abs(plane.offset))
    band = np.maximum(band, np.float32(options.plane_sigmas * plane.tolerance))
    inliers = (z > 0) & (np.abs(height) < band)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        inliers.astype(np.uint8), connectivity=4
    )
    if count < 2:
        return None
    largest = labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    small = np.count_nonzero(largest) < BEND_MAX_SHARE * largest.size
    height[z <= 0] = -np.inf
    if small and not extra and _bends_away(largest, height, band):
        return None
    axes = perpendicular_pair(plane.normal)
    return Support(plane, _hull(largest, plane, k, axes), axes, depth)


def _bends_away(
    plane: NDArray[np.bool_], height: NDArray[np.float32], band: NDArray[np.float32]
) -> bool:
    """Whether the surface goes on below the plane all around: the top of a ball, no support."""
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
    # A projection keeps convexity, so the image's few hull pixels give the hull on the plane.
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
def plane_scores(candidates, offsets, q, rays, normals, weights, tolerance):
    """Weight of the readings that speak for each plane: candidates (C, 3), offsets (C,)."""
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
    candidate: NDArray[np.float64],
    offset: float,
    q: NDArray[np.float64],
    rays: NDArray[np.float64],
    normals: NDArray[np.float64],
    weights: NDArray[np.float64],
    tolerance: float,
) -> NDArray[np.bool_]:
    """Readings of weight > 0 on a plane and with its normal, (N,) bool."""
    near = np.abs(rays @ candidate / offset + q) < tolerance
    return near & (normals @ candidate > MIN_COSINE) & (weights > 0)

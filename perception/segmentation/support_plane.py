"""Detection of the planes that objects stand on."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .above_support import SUPPORT_SIGMAS
from .frame_noise import NoiseProfile
from .local_planes import MIN_WINDOW_SHARE, LocalPlanes, fit_centred_windows, plane_normals
from .median import median
from .options import SegmentationOptions
from .parallel_planes import FlatReadings, flat_readings
from .plane_votes import (
    MIN_COSINE,
    facing_rays,
    fit_tukey_plane,
    plane_distances,
    plane_inliers,
    score_planes,
)
from .result import SupportPlane
from .select_supports import (
    MIN_DISTANCE,
    MIN_FIRST_AREA,
    further_boards,
    select_supports,
    with_small_table,
)
from .support_extent import Support, locate_support
from .support_scatter import support_wave
from .working_image import WorkingImage

CANDIDATES = 480
"""Planes that are tried as the support. More find smaller tables and take longer. Mirrored images
of a bent table give one plane within 3 mm for 6 of 8 seeds with 480, for 1 of 8 with 120."""
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
MAX_TILT = 0.35
"""Maximum angle between the normal and the vertical where the camera's pose is known, rad."""
HEIGHT_TOLERANCE = 0.05
"""Maximum distance of a support from the known height of the table, m."""
NEAR_SHARE = 0.35
"""Readings nearer than this share of the median depth weigh no more than those at it. Otherwise a
gripper in front of the lens would outweigh the table."""
MAX_PROPOSED = 10
"""Maximum number of proposed planes."""
MIN_TILTED_WEIGHT = 0.05
"""Minimum weight, relative to the first plane, of a plane that is not parallel to it. A lower one
is neither the support nor a rival of it: small faces show up to 5 times fewer samples than
readings."""
MIN_INLIERS = 12
"""Minimum number of samples that determine a plane."""
MIN_SHARE = 0.008
"""Minimum share of the samples that are inliers of a proposed plane."""
TUKEY_WIDTH = 1.5
"""Residual at which the weight of a reading reaches 0, in tolerances. The plane is then a smooth
function of the readings. A hard limit moved it by up to 12 mm when 0.5 % of the readings moved by
1 mm."""
MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


class ProposedPlane(NamedTuple):
    """A plane that may be a support."""

    plane: SupportPlane
    """The plane, camera frame."""
    depth: float
    """Median depth of its inliers, m."""
    weight: float
    """Sum of their weights."""


class PlaneSamples(NamedTuple):
    """Readings on which candidate planes are scored."""

    disparity: NDArray[np.float64]
    """(N,), 1/m."""
    rays: NDArray[np.float64]
    """Directions with z = 1, (N, 3)."""
    normals: NDArray[np.float64]
    """Unit normals of their local planes, (N, 3)."""


def find_supports(
    image: WorkingImage,
    options: SegmentationOptions,
    noise: NoiseProfile | None = None,
    readings: FlatReadings | None = None,
) -> list[Support]:
    """Detect the planes that objects stand on, best first; empty when there is none.

    RANSAC proposes planes. The local plane of one pixel is a hypothesis. It comes from wide windows
    on a reduced image, or from the pixels' own windows if none of these is flat enough. Each
    proposed plane is then judged by its visible parts (:func:`.support_extent.locate_support`).

    The plane with the best score is the first support, with two exceptions. The top of an object
    is no support: a small plane little above a larger one. The floor is no support: a plane far
    below another one. Further supports are parallel planes of at least ``MIN_AREA``, such as
    shelves.

    If the camera's pose is known, a support must be horizontal within ``MAX_TILT``. With
    ``table_height`` it must also lie at that height. Equal frames give equal planes.

    `noise` is the noise over disparity, by default the one of the image everywhere. `readings` are
    the flat readings of the image.
    """
    noise = noise or NoiseProfile(np.ones(1), np.full(1, image.noise))
    readings = readings or flat_readings(image, noise)
    stride = max(image.intrinsics.width // COARSE_WIDTH, 1)
    coarse = np.ascontiguousarray(image.disparity[::stride, ::stride])
    planes = LocalPlanes(*fit_centred_windows(coarse, COARSE_RADIUS, COARSE_SHARE))
    proposed = _propose_planes(image, noise, planes, options.table_height)
    if not proposed and stride > 1:
        radius = options.window // 2
        planes = LocalPlanes(*fit_centred_windows(image.disparity, radius, MIN_WINDOW_SHARE))
        proposed = _propose_planes(image, noise, planes, options.table_height)
    supports = [
        support
        for one in _relevant(proposed)
        if _located(one.plane, one.depth, image) is not None
        and (support := _located(_fit_readings(one.plane, readings, noise), one.depth, image))
        is not None
    ]
    supports.sort(key=lambda support: -support.score)
    small: list[Support] = []
    if supports:
        boards, small = further_boards(readings, supports, image)
        supports += boards
    selected = select_supports(sorted(supports, key=lambda support: -support.score), image)
    selected[:1] = [with_small_table(one, small) for one in selected[:1]]
    return [one._replace(wave=support_wave(image, one, SUPPORT_SIGMAS)) for one in selected]


def _located(plane: SupportPlane, depth: float, image: WorkingImage) -> Support | None:
    """Locate a support; None if it is too small, or cannot be one.

    A proposed plane must pass before it is fitted to all readings, too: through all of them the top
    of a tall box is just large enough.
    """
    support = locate_support(plane, depth, image)
    large = support is not None and support.area >= MIN_FIRST_AREA and support.score > 0
    return support if large else None


def _relevant(proposed: list[ProposedPlane]) -> list[ProposedPlane]:
    """Return the planes without those that cannot be a support, nor a rival of one."""
    return [
        one
        for one in proposed
        if one.weight >= MIN_TILTED_WEIGHT * proposed[0].weight
        or float(one.plane.normal @ proposed[0].plane.normal) > MIN_COSINE
    ]


def _propose_planes(
    image: WorkingImage, noise: NoiseProfile, planes: LocalPlanes, table_height: float | None
) -> list[ProposedPlane]:
    """Return up to ``MAX_PROPOSED`` planes.

    `planes` are those of the image, or of a reduced image.
    """
    stride = -(-image.depth.shape[1] // planes.value.shape[1])
    normals = plane_normals(planes, image.intrinsics.reduced(stride))
    flat = (planes.rms >= 0) & (planes.rms < COARSE_SIGMAS * noise.at(planes.value))
    order = _shuffled(flat.size)
    rows, columns = np.unravel_index(order[flat.ravel()[order]][:SAMPLES], flat.shape)
    if rows.size == 0:
        return []
    sample_normals = normals[rows, columns].astype(np.float64)
    rows, columns = rows * stride, columns * stride
    k = image.intrinsics
    z = image.depth[rows, columns].astype(np.float64)
    rays = np.ones((rows.size, 3))
    rays[:, 0], rays[:, 1] = (columns - k.cx) / k.fx, (rows - k.cy) / k.fy
    points = rays * z[:, None]

    tried = np.arange(min(CANDIDATES, rows.size))
    tried = tried[_is_plausible(points[tried], sample_normals[tried], image, table_height)]
    if tried.size == 0:
        return []
    candidates = sample_normals[tried]
    offsets = -np.einsum("ij,ij->i", candidates, points[tried])
    # The weight of squared disparity prefers the table to a floor that fills more pixels.
    weights = 1.0 / np.maximum(z, NEAR_SHARE * float(median(z))) ** 2
    proposed: list[ProposedPlane] = []
    free = np.ones(rows.size, bool)
    tolerance = SUPPORT_SIGMAS * noise.at(1.0 / z)
    samples = PlaneSamples(1.0 / z, rays, sample_normals)
    votes = plane_inliers(candidates, offsets, samples, tolerance)
    for _ in range(MAX_PROPOSED):
        scores = score_planes(votes, weights * free)
        best = int(np.argmax(scores))
        inliers = votes[best] & free
        if inliers.sum() < max(MIN_INLIERS, MIN_SHARE * rows.size):
            break
        free &= ~inliers
        plane_fit = _refit(-candidates[best] / offsets[best], rays, z, tolerance)
        if plane_fit is None:
            continue
        plane, inliers = plane_fit
        proposed.append(ProposedPlane(plane, float(median(z[inliers])), float(scores[best])))
        # Remove the whole neighbourhood of the plane, so that its edge does not win next.
        free &= np.abs(points @ plane.normal + plane.offset) > MIN_DISTANCE
    return proposed


@lru_cache(maxsize=4)
def _shuffled(count: int) -> NDArray[np.intp]:
    """Return the numbers 0..count - 1 in an order that is random and always the same.

    The first flat pixels in this order are the samples. If a pixel stops being flat, one sample
    changes. On a grid over the flat pixels all later samples would change, and with them the plane.
    """
    return np.random.default_rng(0).permutation(count)


def _is_plausible(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    image: WorkingImage,
    table_height: float | None,
) -> NDArray[np.bool_]:
    """Mark the horizontal planes at the known height; all planes if the pose is unknown."""
    if image.T_world_camera is None:
        return np.ones(len(points), bool)
    up = image.T_world_camera.as_matrix()[2, :3]
    plausible = normals @ up >= np.cos(MAX_TILT)
    if table_height is not None:
        height = image.T_world_camera.apply(points)[:, 2]
        plausible &= np.abs(height - table_height) <= HEIGHT_TOLERANCE
    return plausible


def _fit_readings(plane: SupportPlane, readings: FlatReadings, noise: NoiseProfile) -> SupportPlane:
    """Fit a proposed plane to all readings whose windows have its normal.

    Few samples lie on a board that is seen at a grazing angle. The plane through them depends on
    the hypothesis: boards of shelves were tilted by 0.16° in the mean, and mirrored real frames had
    their support up to 70 mm elsewhere. Through all readings these are 0.04° and 3 mm.
    """
    rays, z = facing_rays(readings, plane.normal)
    tolerance = SUPPORT_SIGMAS * noise.at(1.0 / z)
    fit = _refit(-plane.normal / plane.offset, rays, z, tolerance)
    return plane if fit is None else fit[0]


def _refit(
    n: NDArray[np.floating],
    rays: NDArray[np.float64],
    z: NDArray[np.float64],
    tolerance: NDArray[np.float64],
) -> tuple[SupportPlane, NDArray[np.bool_]] | None:
    """Fit the plane n·X = 1 with Tukey's weights; return it and its inliers, None if too few."""
    q = 1.0 / z
    n = fit_tukey_plane(n, rays, q, TUKEY_WIDTH * tolerance)
    if not n.any():
        return None
    length = np.linalg.norm(n)
    normal, offset = -n / length, 1.0 / length
    inliers, distances = plane_distances(n, (normal, offset), rays, z, tolerance)
    if len(distances) < MIN_INLIERS:
        return None
    return SupportPlane(normal, float(offset), float(MAD_TO_SIGMA * median(distances))), inliers

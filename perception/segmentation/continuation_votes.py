"""Compiled votes on surfaces that continue each other behind an occluder.

From each border pixel of a region its plane is extrapolated outwards in up to eight directions. The
extrapolation continues behind pixels without a reading, and behind pixels of another region in
front of the plane. It stops at an unlabelled reading. Where it comes out on another region, that
region agrees if its plane continues the first one and does not bend inwards.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from .local_planes import STEP_SIGMAS
from .working_image import WorkingImage

MAX_REACH = 160
"""Maximum distance behind an occluder over which a surface is continued, px in an image of
``working_image.REFERENCE_WIDTH``."""
MAX_ERROR_SIGMAS = 4.0
"""Maximum error of a continued surface, in σ of the disparity noise."""
ERROR_GROWTH_SIGMAS = 0.25
"""Increase of `MAX_ERROR_SIGMAS` with the distance, in σ per px. The slope is uncertain too."""
MAX_SLOPE_SIGMAS = 0.9
"""Maximum change of slope of a continued surface, in σ per px."""
MAX_ANGLE = 0.4
"""Maximum angle between the planes at the two ends of a continued surface, rad."""
MAX_DENT = 0.15
"""Maximum angle if the surface is concave between its ends, rad. Convex solids have none."""
MIN_DISTANCE = 3
"""Minimum distance of the two ends of a continued surface, px."""
REACHING, AGREEING = range(2)
"""Columns of the votes: pixels that reach the other region, and those that agree with it."""


class ContinuationLimits(NamedTuple):
    """Thresholds of :func:`continuation_votes`."""

    reach: int
    """Distance behind an occluder at which the search stops, px."""
    inset: int
    """Distance from the outline at which planes are read, px."""
    min_step: np.float32
    """Minimum disparity of an occluder above that of the continued surface behind it, 1/m."""
    max_error: np.float32
    """Maximum error in disparity, 1/m."""
    error_growth: np.float32
    """Increase of the maximum error with the distance, 1/(m px)."""
    max_slope: np.float32
    """Maximum change of slope, 1/(m px)."""
    focal: float
    """Focal length, px."""
    max_turn: np.float32
    """Tangent of the maximum angle between the planes at the two ends."""
    max_dent: np.float32
    """Tangent of the maximum angle if the surface is concave."""


def continuation_limits(image: WorkingImage, window: int) -> ContinuationLimits:
    """Return the thresholds for an image whose planes were fitted to windows of side `window` px.

    Planes nearer to an outline than half a window are not used.
    """
    return ContinuationLimits(
        image.length(MAX_REACH),
        window // 2 + 2,
        np.float32(STEP_SIGMAS * image.noise),
        np.float32(MAX_ERROR_SIGMAS * image.noise),
        np.float32(ERROR_GROWTH_SIGMAS * image.noise),
        np.float32(MAX_SLOPE_SIGMAS * image.noise),
        image.intrinsics.fx,
        np.float32(np.tan(MAX_ANGLE)),
        np.float32(np.tan(MAX_DENT)),
    )


@njit(cache=True, nogil=True)
def continuation_votes(labels, q, planes, count, limits):
    """Count for each pair (a, b) the border pixels of a that reach b, and those that agree with b.

    Returns (count + 1, count + 1, 2) int32, with the columns REACHING and AGREEING.
    """
    rows, columns = labels.shape
    votes = np.zeros((count + 1, count + 1, 2), np.int32)
    # Per region: 0 = not reached from this pixel, 1 = reached, 2 = agrees.
    best = np.zeros(count + 1, np.int8)
    reached = np.empty(8, np.int32)
    at_border = np.empty(columns, np.bool_)
    for v in range(rows):
        _mark_borders(labels, v, at_border)
        for u in range(columns):
            if not at_border[u]:
                continue
            a = labels[v, u]
            hits = 0
            for dv in range(-1, 2):
                for du in range(-1, 2):
                    y, x = v + dv, u + du
                    if (dv == 0 and du == 0) or y < 0 or x < 0 or y >= rows or x >= columns:
                        continue
                    if labels[y, x] == a:
                        continue
                    b, agrees = _follow_plane(labels, q, planes, limits, (v, u), (dv, du))
                    if b == 0:
                        continue
                    if best[b] == 0:
                        reached[hits] = b
                        hits += 1
                    best[b] = max(best[b], 2 if agrees else 1)
            for k in range(hits):
                b = reached[k]
                votes[a, b, REACHING] += 1
                if best[b] == 2:
                    votes[a, b, AGREEING] += 1
                best[b] = 0
    return votes


@njit(cache=True, nogil=True)
def _mark_borders(labels, v, at_border):
    """Mark the labelled pixels of row v with another label among their eight neighbours, (W,).

    The compiler handles several pixels of this loop at once.
    """
    rows, columns = labels.shape
    here, above, below = labels[v], labels[max(v - 1, 0)], labels[min(v + 1, rows - 1)]
    for u in range(1, columns - 1):
        a = here[u]
        same = (here[u - 1] == a) & (here[u + 1] == a) & (above[u] == a) & (below[u] == a)
        same &= (above[u - 1] == a) & (above[u + 1] == a)
        same &= (below[u - 1] == a) & (below[u + 1] == a)
        at_border[u] = (a != 0) & (not same)
    at_border[0], at_border[columns - 1] = here[0] != 0, here[columns - 1] != 0


@njit(cache=True, nogil=True)
def _follow_plane(labels, q, planes, limits, pixel, direction):
    """Follow a border pixel's plane behind an occluder.

    Return the label of the region that it reaches, or 0, and whether both planes form one surface.
    """
    value, slope_u, slope_v, inset = planes.value, planes.slope_u, planes.slope_v, limits.inset
    rows, columns = labels.shape
    (v, u), (dv, du) = pixel, direction
    a = labels[v, u]
    # The readings at an outline are distorted, so the plane is read further inside.
    iv, iu = v - inset * dv, u - inset * du
    if iv < 0 or iu < 0 or iv >= rows or iu >= columns:
        return 0, False
    if labels[iv, iu] != a or value[iv, iu] <= 0:
        return 0, False
    slope = slope_u[iv, iu] * du + slope_v[iv, iu] * dv
    start = value[iv, iu] + slope * inset
    for step in range(1, limits.reach):
        y, x = v + step * dv, u + step * du
        if y < 0 or x < 0 or y >= rows or x >= columns:
            break
        if q[y, x] <= 0:
            continue
        max_error = limits.max_error + limits.error_growth * (step + inset)
        b = labels[y, x]
        if q[y, x] - start - slope * step > max(max_error, limits.min_step):
            if b == 0:
                break
            continue
        if b == 0 or b == a or step < MIN_DISTANCE:
            break
        y, x = y + inset * dv, x + inset * du
        if y < 0 or x < 0 or y >= rows or x >= columns:
            break
        if labels[y, x] != b or value[y, x] <= 0:
            break
        ends = (iv, iu), (y, x)
        return b, _continues(planes, limits, ends, direction, start, step + inset)
    return 0, False


@njit(cache=True, nogil=True)
def _continues(planes, limits, ends, direction, start, distance):
    """Return whether the planes at both ends of a hidden surface continue each other."""
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    ((iv, iu), (y, x)), (dv, du) = ends, direction
    max_error = limits.max_error + limits.error_growth * (distance + limits.inset)
    # A plane turned by a small angle changes its slope by q / f times that angle.
    max_slope = min(limits.max_slope, limits.max_turn * value[y, x] / limits.focal)
    slope = slope_u[iv, iu] * du + slope_v[iv, iu] * dv
    back = slope_u[y, x] * du + slope_v[y, x] * dv
    return (
        abs(value[y, x] - start - slope * distance) <= max_error
        and abs(value[y, x] - back * distance - start) <= max_error
        and abs(slope_u[y, x] - slope_u[iv, iu]) <= max_slope
        and abs(slope_v[y, x] - slope_v[iv, iu]) <= max_slope
        # Between two solids that face each other, the surface would be concave.
        and back - slope <= limits.max_dent * value[y, x] / limits.focal
    )

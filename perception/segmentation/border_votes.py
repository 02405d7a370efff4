"""Compiled votes of the pixel pairs on the border of two patches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

BEND_REACH = 4
"""Distance from the border at which the bend is measured, px at the reference width. A longer one
is more reliable, a shorter one works for smaller parts."""
BEND_SIGMAS = 3.0
"""Bend in disparity that counts with full weight, in σ."""
PAIRS, CONTACT, WEIGHT, CONCAVITY = range(4)
"""Columns of the votes: pixel pairs, pairs in contact, weight of their bends, weighted concave
angles in rad."""


class BorderLimits(NamedTuple):
    """Thresholds of :func:`border_votes`."""

    max_step: np.float32
    """Maximum step in disparity between pixels in contact, 1/m."""
    max_crease: np.float32
    """Maximum change of slope at a crease, 1/(m px)."""
    full_bend: np.float32
    """Bend in disparity that counts with full weight, 1/m."""
    reach: int
    """Distance from the border at which the bend is measured, px."""


@njit(cache=True, nogil=True)
def border_votes(patches, counted, q, planes, pinhole, limits):
    """Return (patch a < patch b) and (1, contact, weight, weighted angle) of all border pairs.

    Only borders of the patches marked in `counted` (n + 1,) count.
    """
    rows, columns = patches.shape
    at_border = _mark_borders(patches)
    capacity = 2 * np.count_nonzero(at_border)
    pairs = np.empty((capacity, 2), np.int64)
    votes = np.zeros((capacity, 4), np.float32)
    k = 0
    for v in range(rows):
        for u in range(columns):
            if not at_border[v, u]:
                continue
            a = patches[v, u]
            for dv, du in ((0, 1), (1, 0)):
                y, x = v + dv, u + du
                if y >= rows or x >= columns:
                    continue
                b = patches[y, x]
                if b <= 0 or b == a or not (counted[a] or counted[b]):
                    continue
                pairs[k, 0], pairs[k, 1] = min(a, b), max(a, b)
                votes[k, PAIRS] = 1.0
                if _in_contact(q, planes, limits, (v, u), (dv, du)):
                    votes[k, CONTACT] = 1.0
                    weight, second = _bend(patches, q, planes, limits, (v, u), (dv, du))
                    if weight > 0:
                        angle = _angle(planes, pinhole, (v, u), (y, x))
                        votes[k, WEIGHT] = weight
                        votes[k, CONCAVITY] = angle * weight * np.sign(second)
                k += 1
    return pairs[:k], votes[:k]


@njit(cache=True, nogil=True)
def sum_border_votes(pairs, votes, count):
    """Sum the votes (N, 4) of equal pairs (N, 2) of the patches 1..`count`.

    Returns the different pairs (K, 2), sorted, and the sums of their votes (K, 4) float64.
    """
    row_of = np.full((count + 1, count + 1), -1)
    for i in range(len(pairs)):
        row_of[pairs[i, 0], pairs[i, 1]] = 0
    different = 0
    for a in range(count + 1):
        for b in range(count + 1):
            if row_of[a, b] == 0:
                row_of[a, b] = different
                different += 1
    summed, sums = np.empty((different, 2), np.int64), np.zeros((different, 4))
    for i in range(len(pairs)):
        row = row_of[pairs[i, 0], pairs[i, 1]]
        summed[row] = pairs[i]
        sums[row] += votes[i]
    return summed, sums


@njit(cache=True, nogil=True)
def _mark_borders(patches):
    """Mark the pixels (H, W) of a patch with another patch to the right or below.

    The compiler handles several pixels of this loop at once.
    """
    rows, columns = patches.shape
    marks = np.zeros((rows, columns), np.bool_)
    for v in range(rows):
        here, row = patches[v], marks[v]
        below = patches[min(v + 1, rows - 1)]
        for u in range(columns):
            row[u] = (here[u] > 0) & (below[u] > 0) & (below[u] != here[u])
        for u in range(columns - 1):
            row[u] |= (here[u] > 0) & (here[u + 1] > 0) & (here[u + 1] != here[u])
    return marks


@njit(cache=True, nogil=True)
def _in_contact(q, planes, limits, pixel, step):
    """Return whether two neighbouring pixels have no step in disparity between them.

    At a crease their planes intersect between the pixels. Then the errors of the two planes at
    each other's reading add up to the change of slope. This change is subtracted, but only up to
    a limit: the rim of a round solid is so steep that its plane would bridge any step.
    """
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    (v, u), (dv, du) = pixel, step
    y, x = v + dv, u + du
    if value[v, u] <= 0 or value[y, x] <= 0:
        return False
    rise = q[y, x] - q[v, u]
    near = rise - slope_u[v, u] * du - slope_v[v, u] * dv
    far = rise - slope_u[y, x] * du - slope_v[y, x] * dv
    crease = min(abs(far - near), limits.max_crease)
    return abs(near) + abs(far) - crease < limits.max_step


@njit(cache=True, nogil=True)
def _bend(patches, q, planes, limits, pixel, step):
    """Return the weight of the bend between two pixels in contact, and its second difference.

    The sign of the bend comes from the disparities themselves, because a shifted window may have
    crossed the border. The weight is 0 where the patches are too narrow to measure it.
    """
    slope_u, slope_v, reach = planes.slope_u, planes.slope_v, limits.reach
    rows, columns = patches.shape
    (v, u), (dv, du) = pixel, step
    y, x = v + dv, u + du
    rise_u = slope_u[y, x] - slope_u[v, u]
    rise_v = slope_v[y, x] - slope_v[v, u]
    bend = np.sqrt(rise_u * rise_u + rise_v * rise_v)
    along = rise_u * du + rise_v * dv
    by, bx = v - reach * dv, u - reach * du
    ay, ax = y + reach * dv, x + reach * du
    if (
        bend <= 0
        or by < 0
        or bx < 0
        or ay >= rows
        or ax >= columns
        or patches[by, bx] != patches[v, u]
        or patches[ay, ax] != patches[y, x]
    ):
        return 0.0, 0.0
    second = q[by, bx] + q[ay, ax] - q[v, u] - q[y, x]
    clear = min(abs(second) / limits.full_bend, np.float32(1.0))
    return clear * abs(along) / bend, second


@njit(cache=True, nogil=True)
def _angle(planes, pinhole, a, b):
    """Return the angle between the planes at two pixels, rad."""
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    fx, fy, cx, cy = pinhole
    (v, u), (y, x) = a, b
    ax, ay = slope_u[v, u] * fx, slope_v[v, u] * fy
    az = value[v, u] - slope_u[v, u] * (u - cx) - slope_v[v, u] * (v - cy)
    bx, by = slope_u[y, x] * fx, slope_v[y, x] * fy
    bz = value[y, x] - slope_u[y, x] * (x - cx) - slope_v[y, x] * (y - cy)
    dot = ax * bx + ay * by + az * bz
    lengths = np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    return np.arccos(min(max(dot / lengths, -1.0), 1.0))

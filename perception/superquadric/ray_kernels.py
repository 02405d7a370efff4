"""Compiled depths by which rays of the view enter the solid, many rays at a time."""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .radial_batch_kernels import compute_radial_rows
from .work_rows import FAST_MATH, LANES, away_from_zero, lane_count

_ITERATIONS = 60
_TOLERANCE = 1e-7
"""Brackets shorter than this have converged, in bounding radii."""
_MIN_SLOPE = 1e-5
"""A flatter G has converged, per bounding radius: the depth is then right to its square."""
_BOUNDING_RADIUS = 1.8
"""A sphere of radius sqrt(3) times the largest semi-axis contains every straight superquadric."""
_DX_ROW, _DY_ROW, _DZ_ROW, _LOW, _G_LOW, _S_LOW, _HIGH, _G_HIGH, _S_HIGH = range(
    at.FIRST_FREE_ROW, at.FIRST_FREE_ROW + 9
)
_TIME_ROW, _SLOPE_ROW, _STATE = range(at.FIRST_FREE_ROW + 9, at.FIRST_FREE_ROW + 12)
_DX, _DY, _DZ = _DX_ROW * LANES, _DY_ROW * LANES, _DZ_ROW * LANES
TIME, _SLOPE = _TIME_ROW * LANES, _SLOPE_ROW * LANES
"""Distances along the rays, and the slopes of G there."""
_SEARCHING, _FOUND, _MISSED = 1.0, 0.0, -1.0


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def compute_ray_rows(rays, view_origin, first, n, shape, tapered, outside, work):
    """Compute the depths s (1 - min G) by which rays enter the solid, and their derivatives.

    s is the smallest semi-axis. The derivative at the minimum over the ray needs no derivative of
    the minimiser (envelope theorem).

    Parameters
    ----------
    rays
        (K, 3) unit directions from `view_origin`.
    first, n
        First ray and number of rays, at most LANES.
    shape, tapered
        As in :func:`~.cost_kernels.normal_equations`.
    outside
        Whether rays that miss the solid get a negative depth instead of 0.
    work
        Working memory. Row k receives the derivatives by parameter k, row RESIDUAL the depths.
        The derivatives of a ray with depth 0 are undefined. Row TIME receives the distances along
        the rays at which G is smallest.

    Returns
    -------
    tuple
        The origin of the rays in local axes, 3 numbers.
    """
    lanes = lane_count(n)
    R, c, log_axes = shape.R, shape.centre, shape.log_axes
    m, grid = work.flat, work.grid
    # The origin in local axes.
    ox, oy, oz = view_origin[0] - c[0], view_origin[1] - c[1], view_origin[2] - c[2]
    o1 = R[0, 0] * ox + R[1, 0] * oy + R[2, 0] * oz
    o2 = R[0, 1] * ox + R[1, 1] * oy + R[2, 1] * oz
    o3 = R[0, 2] * ox + R[1, 2] * oy + R[2, 2] * oz
    reach = np.exp(max(log_axes[0], log_axes[1], log_axes[2])) * _BOUNDING_RADIUS
    if tapered:
        reach *= 1.0 + max(abs(shape.taper[0]), abs(shape.taper[1]))
    for i in range(lanes):
        k = first + min(i, n - 1)
        x, y, z = rays[k, 0], rays[k, 1], rays[k, 2]
        d1 = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
        d2 = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
        d3 = R[0, 2] * x + R[1, 2] * y + R[2, 2] * z
        middle = -(d1 * o1 + d2 * o2 + d3 * o3)
        miss = (o1 + middle * d1) ** 2 + (o2 + middle * d2) ** 2 + (o3 + middle * d3) ** 2
        grid[_DX_ROW, i], grid[_DY_ROW, i], grid[_DZ_ROW, i] = d1, d2, d3
        grid[_LOW, i], grid[_HIGH, i] = middle - reach, middle + reach
        # A ray that misses the bounding sphere misses the solid.
        far = miss > reach * reach and not outside
        grid[_STATE, i] = _MISSED if far or i >= n else _SEARCHING
    for side in range(2):
        time, value, slope = (_HIGH, _G_HIGH, _S_HIGH) if side else (_LOW, _G_LOW, _S_LOW)
        for i in range(lanes):
            grid[_TIME_ROW, i] = grid[time, i]
        evaluate_on_rays((o1, o2, o3), shape, tapered, work, lanes)
        for i in range(lanes):
            grid[value, i] = 1.0 / grid[at.INV_G_ROW, i]
            grid[slope, i] = grid[_SLOPE_ROW, i]
    for iteration in range(_ITERATIONS):
        if not _choose_times(iteration, outside, tapered, grid, lanes):
            break
        evaluate_on_rays((o1, o2, o3), shape, tapered, work, lanes)
        _shrink_brackets(reach, grid, lanes)
    write_depths(log_axes, shape.taper, outside, m, grid, lanes)
    return o1, o2, o3


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def evaluate_on_rays(origin, shape, tapered, work, lanes):
    """Compute G at the current times of the rays, and its slope along them."""
    m, taper = work.flat, shape.taper
    o1, o2, o3 = origin
    for i in range(lanes):
        time = m[TIME + i]
        m[at.X + i] = away_from_zero(o1 + time * m[_DX + i])
        m[at.Y + i] = away_from_zero(o2 + time * m[_DY + i])
        m[at.Z + i] = away_from_zero(o3 + time * m[_DZ + i])
    compute_radial_rows(shape, tapered, work, lanes)
    for i in range(lanes):
        p1 = m[at.SHARE_XY + i] * m[at.SHARE_X + i]
        p2 = m[at.SHARE_XY + i] * m[at.SHARE_Y + i]
        lean1 = taper[0] * m[at.HEIGHT_SLOPE + i] * m[at.INV_WIDTH_X + i]
        lean2 = taper[1] * m[at.HEIGHT_SLOPE + i] * m[at.INV_WIDTH_Y + i]
        g3 = m[at.SHARE_HEIGHT + i] / m[at.Z + i] - p1 * lean1 - p2 * lean2
        along = p1 / m[at.X + i] * m[_DX + i] + p2 / m[at.Y + i] * m[_DY + i] + g3 * m[_DZ + i]
        m[_SLOPE + i] = along / m[at.INV_G + i]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _choose_times(iteration, outside, tapered, grid, lanes):
    """Select the next time of each ray; return whether any ray is still searched."""
    searching = False
    for i in range(lanes):
        if grid[_STATE, i] != _SEARCHING:
            continue
        low, g_low, s_low = grid[_LOW, i], grid[_G_LOW, i], grid[_S_LOW, i]
        high, g_high, s_high = grid[_HIGH, i], grid[_G_HIGH, i], grid[_S_HIGH, i]
        if s_low >= 0.0 or s_high <= 0.0:
            grid[_STATE, i] = _FOUND if outside else _MISSED
            continue
        # A convex function lies above its tangents. Their intersection is a bound and a good
        # guess. With a taper G is not convex, and the intersection is a guess only.
        t = (g_high - g_low + s_low * low - s_high * high) / (s_low - s_high)
        if not (outside or tapered) and g_low + s_low * (t - low) >= 1.0:
            grid[_STATE, i] = _MISSED
            continue
        # Tangents find kinks at once but only halve smooth brackets. The cubic through both ends
        # finds smooth minima. They alternate, with a bisection every fourth time.
        turn = iteration % 4
        if turn % 2 == 0:
            mean = s_low + s_high - 3.0 * (g_high - g_low) / (high - low)
            root = np.sqrt(mean * mean - s_low * s_high)
            t = high - (high - low) * (s_high + root - mean) / (s_high - s_low + 2.0 * root)
        if turn == 3 or not (low < t < high):
            t = 0.5 * (low + high)
        grid[_TIME_ROW, i] = t
        searching = True
    return searching


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _shrink_brackets(reach, grid, lanes):
    """Replace an end of each bracket by the evaluated time."""
    for i in range(lanes):
        if grid[_STATE, i] != _SEARCHING:
            continue
        slope = grid[_SLOPE_ROW, i]
        if slope < 0.0:
            grid[_LOW, i], grid[_S_LOW, i] = grid[_TIME_ROW, i], slope
            grid[_G_LOW, i] = 1.0 / grid[at.INV_G_ROW, i]
        else:
            grid[_HIGH, i], grid[_S_HIGH, i] = grid[_TIME_ROW, i], slope
            grid[_G_HIGH, i] = 1.0 / grid[at.INV_G_ROW, i]
        closed = grid[_HIGH, i] - grid[_LOW, i] < _TOLERANCE * reach
        if closed or abs(slope) * reach < _MIN_SLOPE:
            grid[_STATE, i] = _FOUND


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def write_depths(log_axes, taper, outside, m, grid, lanes):
    """Write depths and derivatives at the minima of G along the rays."""
    smallest = 0
    for k in range(1, 3):
        if log_axes[k] < log_axes[smallest]:
            smallest = k
    size = np.exp(log_axes[smallest])
    for i in range(lanes):
        g = 1.0 / grid[at.INV_G_ROW, i]
        missed = grid[_STATE, i] == _MISSED or (g >= 1.0 and not outside)
        grid[at.RESIDUAL_ROW, i] = 0.0 if missed else size * (1.0 - g)
    for i in range(lanes):
        x, y, z, w, w3 = (
            m[at.X + i],
            m[at.Y + i],
            m[at.Z + i],
            m[at.SHARE_XY + i],
            m[at.SHARE_HEIGHT + i],
        )
        u1, u2 = m[at.SHARE_X + i], m[at.SHARE_Y + i]
        over1, over2 = m[at.INV_WIDTH_X + i], m[at.INV_WIDTH_Y + i]
        outward, slope = -size / m[at.INV_G + i], m[at.HEIGHT_SLOPE + i]
        p1, p2 = outward * w * u1, outward * w * u2
        lean = taper[0] * slope * over1 * p1 + taper[1] * slope * over2 * p2
        m[i], m[LANES + i] = -p1, -p2
        m[2 * LANES + i] = lean * z - outward * w3
        m[3 * LANES + i] = (
            0.5 * outward * (m[at.LOG_F + i] - w * m[at.SECTION_TERM + i] - w3 * m[at.LOG_Z + i])
        )
        entropy = m[at.LOG_A + i] - u1 * m[at.LOG_X + i] - u2 * m[at.LOG_Y + i]
        m[4 * LANES + i] = 0.5 * outward * w * entropy
        v1, v2, v3 = p1 / x, p2 / y, outward * w3 / z - lean
        m[5 * LANES + i] = v2 * z - v3 * y
        m[6 * LANES + i] = v3 * x - v1 * z
        m[7 * LANES + i] = v1 * y - v2 * x
        m[8 * LANES + i], m[9 * LANES + i], m[10 * LANES + i] = -v1, -v2, -v3
        m[11 * LANES + i] = -p1 * m[at.HEIGHT + i] * over1
        m[12 * LANES + i] = -p2 * m[at.HEIGHT + i] * over2
    for i in range(lanes):
        grid[smallest, i] += size - size / grid[at.INV_G_ROW, i]

"""Compiled side condition of a fit: rays of the view that must miss the solid, many at a time."""

from __future__ import annotations

import numpy as np
from numba import njit

from .radial_batch_kernels import (
    AX_ROW,
    AY_ROW,
    FALLING_ROW,
    FREE_ROW,
    HEIGHT_ROW,
    LANES,
    LOG_A_ROW,
    LOG_F_ROW,
    OVER1_ROW,
    OVER2_ROW,
    R_ROW,
    RISE_ROW,
    S_ROW,
    T_ROW,
    U1_ROW,
    U2_ROW,
    W3_ROW,
    W_ROW,
    X_ROW,
    Y_ROW,
    Z_ROW,
    gauge_rows,
    lanes_for,
)
from .radial_kernels import FAST, SMALL

_ITERATIONS = 60
_TOLERANCE = 1e-7
"""Brackets this short are closed, in bounding radii."""
_FLAT = 1e-5
"""A gauge that rises no faster is at its minimum, per bounding radius: the depth is then right to
the square of it."""
_BALL = 1.8
"""Every straight superquadric fits into a ball of sqrt(3) times its largest semi-axis."""
_DX, _DY, _DZ, _LOW, _G_LOW, _S_LOW, _HIGH, _G_HIGH, _S_HIGH, _TIME, _SLOPE, _STATE = range(
    FREE_ROW, FREE_ROW + 12
)
_SEARCHING, _FOUND, _MISSED = 1.0, 0.0, -1.0


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def ray_rows(rays, first, n, origin, axes, eps, R, c, taper, tapered, outside, m, grid, bits):
    """Depths s (1 - min G) by which rays enter the solid, and their derivatives.

    Of a ray that misses, the depth is negative where `outside` asks for it, else 0.
    By the envelope theorem the derivative at the minimum over the ray needs no derivative of
    the minimiser. s is the smallest semi-axis.

    Parameters
    ----------
    rays
        (K, 3) unit directions from `origin`.
    first, n
        Which of them, at most LANES.
    axes, eps, R, c, taper, tapered
        As in :func:`~.residual_kernels.normal_equations`.
    m, grid, bits
        Working memory, see :func:`~.gauge_rows.gauge_rows`; written: derivatives by parameter k in
        row k, depths in row R_ROW; a ray with depth 0 has no derivatives that count.
    """
    lanes = lanes_for(n)
    # The origin in the solid's own axes.
    ox, oy, oz = origin[0] - c[0], origin[1] - c[1], origin[2] - c[2]
    o1 = R[0, 0] * ox + R[1, 0] * oy + R[2, 0] * oz
    o2 = R[0, 1] * ox + R[1, 1] * oy + R[2, 1] * oz
    o3 = R[0, 2] * ox + R[1, 2] * oy + R[2, 2] * oz
    reach = np.exp(max(axes[0], axes[1], axes[2])) * _BALL
    if tapered:
        reach *= 1.0 + max(abs(taper[0]), abs(taper[1]))
    for i in range(lanes):
        k = first + min(i, n - 1)
        x, y, z = rays[k, 0], rays[k, 1], rays[k, 2]
        d1 = R[0, 0] * x + R[1, 0] * y + R[2, 0] * z
        d2 = R[0, 1] * x + R[1, 1] * y + R[2, 1] * z
        d3 = R[0, 2] * x + R[1, 2] * y + R[2, 2] * z
        middle = -(d1 * o1 + d2 * o2 + d3 * o3)
        miss = (o1 + middle * d1) ** 2 + (o2 + middle * d2) ** 2 + (o3 + middle * d3) ** 2
        grid[_DX, i], grid[_DY, i], grid[_DZ, i] = d1, d2, d3
        grid[_LOW, i], grid[_HIGH, i] = middle - reach, middle + reach
        # A ray that misses the bounding ball misses the solid.
        far = miss > reach * reach and not outside
        grid[_STATE, i] = _MISSED if far or i >= n else _SEARCHING
    for side in range(2):
        time, value, slope = (_HIGH, _G_HIGH, _S_HIGH) if side else (_LOW, _G_LOW, _S_LOW)
        for i in range(lanes):
            grid[_TIME, i] = grid[time, i]
        _gauge_on_rays(o1, o2, o3, axes, eps, taper, tapered, m, grid, bits, lanes)
        for i in range(lanes):
            grid[value, i] = 1.0 / grid[FALLING_ROW, i]
            grid[slope, i] = grid[_SLOPE, i]
    for iteration in range(_ITERATIONS):
        if not _next_times(iteration, outside, tapered, grid, lanes):
            break
        _gauge_on_rays(o1, o2, o3, axes, eps, taper, tapered, m, grid, bits, lanes)
        _close_in(reach, grid, lanes)
    _finish(axes, taper, outside, m, grid, lanes)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _gauge_on_rays(o1, o2, o3, axes, eps, taper, tapered, m, grid, bits, lanes):
    """Gauge of the rays' places at their times, and its slope along them."""
    X, Y, Z, TIME = X_ROW * LANES, Y_ROW * LANES, Z_ROW * LANES, _TIME * LANES
    DX, DY, DZ, SLOPE = _DX * LANES, _DY * LANES, _DZ * LANES, _SLOPE * LANES
    for i in range(lanes):
        time = m[TIME + i]
        x, y, z = o1 + time * m[DX + i], o2 + time * m[DY + i], o3 + time * m[DZ + i]
        m[X + i] = (SMALL if x >= 0.0 else -SMALL) if abs(x) < SMALL else x
        m[Y + i] = (SMALL if y >= 0.0 else -SMALL) if abs(y) < SMALL else y
        m[Z + i] = (SMALL if z >= 0.0 else -SMALL) if abs(z) < SMALL else z
    gauge_rows(axes, eps, taper, tapered, m, grid, bits, lanes)
    W, W3, U1, U2 = W_ROW * LANES, W3_ROW * LANES, U1_ROW * LANES, U2_ROW * LANES
    RISE, OVER1, OVER2 = RISE_ROW * LANES, OVER1_ROW * LANES, OVER2_ROW * LANES
    FALLING = FALLING_ROW * LANES
    for i in range(lanes):
        p1, p2 = m[W + i] * m[U1 + i], m[W + i] * m[U2 + i]
        lean1, lean2 = taper[0] * m[RISE + i] * m[OVER1 + i], taper[1] * m[RISE + i] * m[OVER2 + i]
        g3 = m[W3 + i] / m[Z + i] - p1 * lean1 - p2 * lean2
        along = p1 / m[X + i] * m[DX + i] + p2 / m[Y + i] * m[DY + i] + g3 * m[DZ + i]
        m[SLOPE + i] = along / m[FALLING + i]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _next_times(iteration, outside, tapered, grid, lanes):
    """Choose where on each ray to look next; tells whether any is still searched."""
    searching = False
    for i in range(lanes):
        if grid[_STATE, i] != _SEARCHING:
            continue
        low, g_low, s_low = grid[_LOW, i], grid[_G_LOW, i], grid[_S_LOW, i]
        high, g_high, s_high = grid[_HIGH, i], grid[_G_HIGH, i], grid[_S_HIGH, i]
        if s_low >= 0.0 or s_high <= 0.0:
            grid[_STATE, i] = _FOUND if outside else _MISSED
            continue
        # A convex function lies above its tangents: where they meet is a bound and a good guess.
        # A taper bends the gauge, then they are a guess alone.
        t = (g_high - g_low + s_low * low - s_high * high) / (s_low - s_high)
        if not (outside or tapered) and g_low + s_low * (t - low) >= 1.0:
            grid[_STATE, i] = _MISSED
            continue
        # Tangents find kinks at once and only halve what is round; the cubic through both ends
        # finds what is round. In turns, and halving where neither comes nearer.
        turn = iteration % 4
        if turn % 2 == 0:
            mean = s_low + s_high - 3.0 * (g_high - g_low) / (high - low)
            root = np.sqrt(mean * mean - s_low * s_high)
            t = high - (high - low) * (s_high + root - mean) / (s_high - s_low + 2.0 * root)
        if turn == 3 or not (low < t < high):
            t = 0.5 * (low + high)
        grid[_TIME, i] = t
        searching = True
    return searching


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _close_in(reach, grid, lanes):
    """Take the rays' new places as ends of their brackets."""
    for i in range(lanes):
        if grid[_STATE, i] != _SEARCHING:
            continue
        slope = grid[_SLOPE, i]
        if slope < 0.0:
            grid[_LOW, i], grid[_S_LOW, i] = grid[_TIME, i], slope
            grid[_G_LOW, i] = 1.0 / grid[FALLING_ROW, i]
        else:
            grid[_HIGH, i], grid[_S_HIGH, i] = grid[_TIME, i], slope
            grid[_G_HIGH, i] = 1.0 / grid[FALLING_ROW, i]
        closed = grid[_HIGH, i] - grid[_LOW, i] < _TOLERANCE * reach
        if closed or abs(slope) * reach < _FLAT:
            grid[_STATE, i] = _FOUND


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _finish(axes, taper, outside, m, grid, lanes):
    """Write depths and derivatives of the places where the rays are deepest."""
    smallest = 0
    for k in range(1, 3):
        if axes[k] < axes[smallest]:
            smallest = k
    size = np.exp(axes[smallest])
    for i in range(lanes):
        gauge = 1.0 / grid[FALLING_ROW, i]
        missed = grid[_STATE, i] == _MISSED or (gauge >= 1.0 and not outside)
        grid[R_ROW, i] = 0.0 if missed else size * (1.0 - gauge)
    X, Y, Z = X_ROW * LANES, Y_ROW * LANES, Z_ROW * LANES
    HEIGHT, RISE = HEIGHT_ROW * LANES, RISE_ROW * LANES
    OVER1, OVER2, FALLING = OVER1_ROW * LANES, OVER2_ROW * LANES, FALLING_ROW * LANES
    W, W3, U1, U2 = W_ROW * LANES, W3_ROW * LANES, U1_ROW * LANES, U2_ROW * LANES
    AX, AY, S, T = AX_ROW * LANES, AY_ROW * LANES, S_ROW * LANES, T_ROW * LANES
    LOG_A, LOG_F = LOG_A_ROW * LANES, LOG_F_ROW * LANES
    for i in range(lanes):
        x, y, z, w, w3 = m[X + i], m[Y + i], m[Z + i], m[W + i], m[W3 + i]
        u1, u2, over1, over2 = m[U1 + i], m[U2 + i], m[OVER1 + i], m[OVER2 + i]
        outward = -size / m[FALLING + i]
        p1, p2 = outward * w * u1, outward * w * u2
        lean = taper[0] * m[RISE + i] * over1 * p1 + taper[1] * m[RISE + i] * over2 * p2
        m[i], m[LANES + i] = -p1, -p2
        m[2 * LANES + i] = lean * z - outward * w3
        m[3 * LANES + i] = 0.5 * outward * (m[LOG_F + i] - w * m[T + i] - w3 * m[S + i])
        spread = m[LOG_A + i] - u1 * m[AX + i] - u2 * m[AY + i]
        m[4 * LANES + i] = 0.5 * outward * w * spread
        v1, v2, v3 = p1 / x, p2 / y, outward * w3 / z - lean
        m[5 * LANES + i] = v2 * z - v3 * y
        m[6 * LANES + i] = v3 * x - v1 * z
        m[7 * LANES + i] = v1 * y - v2 * x
        m[8 * LANES + i], m[9 * LANES + i], m[10 * LANES + i] = -v1, -v2, -v3
        m[11 * LANES + i] = -p1 * m[HEIGHT + i] * over1
        m[12 * LANES + i] = -p2 * m[HEIGHT + i] * over2
    for i in range(lanes):
        grid[smallest, i] += size - size / grid[FALLING_ROW, i]

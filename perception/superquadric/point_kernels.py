"""Compiled residuals of many points at a time, and what a robust sum of squares makes of them.

The residual of a point is its first-order normal distance r = (G - 1)/‖∇G‖ with the gauge
G = F^(ε1/2) (Sampson 1982 on the function of Solina and Bajcsy 1990). With h = log G, shares
p = ∂h/∂(log x, log y, log z) and n = ‖∇h‖ it reads r = (1 - e^-h)/n: all in logarithms, so that
exponents down to 0.02 neither overflow nor lose digits.
"""

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
    ROWS,
    S_ROW,
    SPARE_ROW,
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
from .vector_kernels import log1p_row

_SQUARE, _COST, _WEIGHT, _SLOPE, _SCALED = range(FREE_ROW, FREE_ROW + 5)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def distance_rows(points, first, n, R, c, axes, eps, taper, tapered, m):
    """Residuals of points ``first`` to ``first + n`` and their derivatives.

    Parameters
    ----------
    points
        (N, 3) cloud.
    first, n
        Which of them, at most LANES.
    R, c, axes, eps, taper, tapered
        As in :func:`~.residual_kernels.normal_equations`.
    m
        (ROWS * LANES,) working memory; written: derivatives by parameter k in row k, residuals in
        row R_ROW.
    """
    lanes = lanes_for(n)
    X, Y, Z = X_ROW * LANES, Y_ROW * LANES, Z_ROW * LANES
    for i in range(lanes):
        # The last point fills the lanes that are left. A NaN stays one, and shows in the cost.
        k = first + min(i, n - 1)
        dx, dy, dz = points[k, 0] - c[0], points[k, 1] - c[1], points[k, 2] - c[2]
        x = R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz
        y = R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz
        z = R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz
        m[X + i] = (SMALL if x >= 0.0 else -SMALL) if abs(x) < SMALL else x
        m[Y + i] = (SMALL if y >= 0.0 else -SMALL) if abs(y) < SMALL else y
        m[Z + i] = (SMALL if z >= 0.0 else -SMALL) if abs(z) < SMALL else z
    grid = m.reshape(ROWS, LANES)
    gauge_rows(axes, eps, taper, tapered, m, grid, grid.view(np.int64), lanes)

    RISE, OVER1, OVER2, HEIGHT = (
        RISE_ROW * LANES,
        OVER1_ROW * LANES,
        OVER2_ROW * LANES,
        HEIGHT_ROW * LANES,
    )
    W, W3, U1, U2 = W_ROW * LANES, W3_ROW * LANES, U1_ROW * LANES, U2_ROW * LANES
    AX, AY, S, T = AX_ROW * LANES, AY_ROW * LANES, S_ROW * LANES, T_ROW * LANES
    LOG_A, LOG_F, FALLING = LOG_A_ROW * LANES, LOG_F_ROW * LANES, FALLING_ROW * LANES
    R_AT = R_ROW * LANES
    k1, k2 = 2.0 / eps[0], 2.0 / eps[1]
    for i in range(lanes):
        x, y, z = m[X + i], m[Y + i], m[Z + i]
        over_x, over_y, over_z = 1.0 / x, 1.0 / y, 1.0 / z
        ax, ay, s, t = m[AX + i], m[AY + i], m[S + i], m[T + i]
        log_a, log_f, falling = m[LOG_A + i], m[LOG_F + i], m[FALLING + i]
        rise, over1, over2 = m[RISE + i], m[OVER1 + i], m[OVER2 + i]
        lean1, lean2 = taper[0] * rise * over1, taper[1] * rise * over2
        w, w3, u1, u2 = m[W + i], m[W3 + i], m[U1 + i], m[U2 + i]
        p1, p2, p3 = w * u1, w * u2, w3
        # ∇h: a step along z also moves between sections.
        g1, g2 = p1 * over_x, p2 * over_y
        g3 = p3 * over_z - p1 * lean1 - p2 * lean2
        over_n = 1.0 / np.sqrt(g1 * g1 + g2 * g2 + g3 * g3)
        r = (1.0 - falling) * over_n
        along, across = falling * over_n, r * over_n
        m[R_AT + i] = r
        # The shares' derivatives by the logarithms of the coordinates (symmetric), and m = ∂n/∂p:
        # r moves with a share by -across m.
        q, o = w * w3 * k1, w * k2 * u1 * u2
        d11, d12, d13 = q * u1 * u1 + o, q * u1 * u2 - o, -q * u1
        d22, d23, d33 = q * u2 * u2 + o, -q * u2, q
        n1, n2, n3 = g1 * over_n, g2 * over_n, g3 * over_n
        m1, m2, m3 = n1 * over_x - n3 * lean1, n2 * over_y - n3 * lean2, n3 * over_z
        r1 = along * p1 - across * (m1 * d11 + m2 * d12 + m3 * d13)
        r2 = along * p2 - across * (m1 * d12 + m2 * d22 + m3 * d23)
        r3 = along * p3 - across * (m1 * d13 + m2 * d23 + m3 * d33)
        m[i], m[LANES + i] = -r1, -r2
        spread = log_a - u1 * ax - u2 * ay
        dw = w * w3 * (s - t) * (0.5 * k1)
        m[3 * LANES + i] = along * 0.5 * (log_f - w * t - w3 * s) - across * dw * (
            m1 * u1 + m2 * u2 - m3
        )
        dw = w * w3 * spread * (0.5 * k1)
        du = -u1 * u2 * (ax - ay) * (0.5 * k2)
        m[4 * LANES + i] = along * 0.5 * w * spread - across * (
            m1 * (dw * u1 + w * du) + m2 * (dw * u2 - w * du) - m3 * dw
        )
        v1 = (r1 + across * n1 * p1 * over_x) * over_x
        v2 = (r2 + across * n2 * p2 * over_y) * over_y
        v3 = (r3 + across * n3 * p3 * over_z) * over_z
        # Without a taper, and beyond its reach, both leans are 0.
        bend = n3 * (p1 * lean1 * lean1 + p2 * lean2 * lean2)
        leaning = r1 * lean1 + r2 * lean2 + across * bend
        v3 -= leaning
        m[2 * LANES + i] = leaning * z - r3 - across * n3 * (p1 * lean1 + p2 * lean2)
        height, pull = m[HEIGHT + i], across * n3 * rise
        m[11 * LANES + i] = over1 * (pull * p1 * over1 - r1 * height)
        m[12 * LANES + i] = over2 * (pull * p2 * over2 - r2 * height)
        m[5 * LANES + i] = v2 * z - v3 * y
        m[6 * LANES + i] = v3 * x - v1 * z
        m[7 * LANES + i] = v1 * y - v2 * x
        m[8 * LANES + i], m[9 * LANES + i], m[10 * LANES + i] = -v1, -v2, -v3


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def add_block(weights, first, n, scale, count, m, gradient, hessian):
    """Add a block's points to gradient (13,) and Hessian (13, 13) under the Cauchy loss.

    Parameters
    ----------
    weights
        (N,) of all points.
    first, n, m
        As for :func:`distance_rows`, which has filled `m`.
    scale
        Of the loss.
    count
        Derivatives in use: PARAMETERS or STRAIGHT.

    Returns
    -------
    float
        The points' cost.
    """
    lanes = lanes_for(n)
    over = 1.0 / scale
    SQUARE, COST, WEIGHT = _SQUARE * LANES, _COST * LANES, _WEIGHT * LANES
    SLOPE, R = _SLOPE * LANES, R_ROW * LANES
    for i in range(lanes):
        m[SQUARE + i] = (m[R + i] * over) ** 2
    grid = m.reshape(ROWS, LANES)
    log1p_row(grid, grid.view(np.int64), _SQUARE, _COST, SPARE_ROW, lanes)
    for i in range(lanes):
        m[WEIGHT + i] = weights[first + i] if i < n else 0.0
    cost = 0.0
    for i in range(lanes):
        cost += m[WEIGHT + i] * m[COST + i]
        m[SLOPE + i] = m[WEIGHT + i] / (1.0 + m[SQUARE + i])
    add_rows(count, m, grid, lanes, gradient, hessian)
    return 0.5 * scale * scale * cost


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def add_ray_block(share, pull, scale, n, count, m, grid, bits, gradient, hessian):
    """Add a block's rays to gradient (13,) and Hessian (13, 13).

    Parameters
    ----------
    share
        Weight of a ray.
    pull
        Weight of rays that pass outside, of that, under the Cauchy loss.
    scale
        Of that loss.
    n, count, m
        As for :func:`add_block`.
    grid, bits
        The same memory as `m`, see :func:`~.gauge_rows.gauge_rows`.

    Returns
    -------
    float
        The rays' cost.
    """
    lanes = lanes_for(n)
    over = 1.0 / scale
    for i in range(lanes):
        grid[_SQUARE, i] = (grid[R_ROW, i] * over) ** 2
    log1p_row(grid, bits, _SQUARE, _COST, SPARE_ROW, lanes)
    cost = 0.0
    for i in range(lanes):
        depth = grid[R_ROW, i] if i < n else 0.0
        if depth > 0.0:
            cost += 0.5 * share * depth * depth
            grid[_SLOPE, i] = share
        elif depth < 0.0:
            cost += 0.5 * share * pull * scale * scale * grid[_COST, i]
            grid[_SLOPE, i] = share * pull / (1.0 + grid[_SQUARE, i])
        else:
            grid[_SLOPE, i] = 0.0
    add_rows(count, m, grid, lanes, gradient, hessian)
    return cost


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def add_rows(count, m, grid, lanes, gradient, hessian):
    """Add weighted residuals and their derivatives, as the rows of working memory hold them."""
    SLOPE, SCALED, R = _SLOPE * LANES, _SCALED * LANES, R_ROW * LANES
    for j in range(count):
        for i in range(lanes):
            m[SCALED + i] = m[SLOPE + i] * grid[j, i]
        falls = 0.0
        for i in range(lanes):
            falls += m[SCALED + i] * m[R + i]
        gradient[j] += falls
        for k in range(j + 1):
            product = 0.0
            for i in range(lanes):
                product += m[SCALED + i] * grid[k, i]
            hessian[j, k] += product

"""Compiled residuals of many points at a time, and their robust sum of squares.

The residual of a point is its first-order normal distance r = (G - 1)/‖∇G‖ with the radial scale
G = F^(ε1/2) (Sampson 1982 on the function of Solina and Bajcsy 1990). With h = log G, shares
p = ∂h/∂(log x, log y, log z) and n = ‖∇h‖ it reads r = (1 - e^-h)/n. All of it is computed in
logarithms, so that exponents down to 0.02 neither overflow nor lose digits.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .radial_batch_kernels import compute_radial_rows
from .vector_kernels import log1p_row
from .work_rows import FAST_MATH, LANES, away_from_zero, lane_count

_SQUARE_ROW, _LOSS_ROW, _WEIGHT_ROW, _SLOPE_ROW, _SCALED_ROW = range(
    at.FIRST_FREE_ROW, at.FIRST_FREE_ROW + 5
)
_SQUARE, _LOSS, _WEIGHT = _SQUARE_ROW * LANES, _LOSS_ROW * LANES, _WEIGHT_ROW * LANES
_SLOPE, _SCALED = _SLOPE_ROW * LANES, _SCALED_ROW * LANES


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def compute_distance_rows(points, first, n, shape, tapered, work):
    """Compute the residuals of points ``first`` to ``first + n`` and their derivatives.

    Parameters
    ----------
    points
        (N, 3) cloud.
    first, n
        First point and number of points, at most LANES.
    shape, tapered
        As in :func:`~.cost_kernels.normal_equations`.
    work
        Working memory. Row k receives the derivatives by parameter k, row RESIDUAL the residuals.
    """
    lanes = lane_count(n)
    m, R, c = work.flat, shape.R, shape.centre
    for i in range(lanes):
        # The last point fills the lanes that are left. A NaN stays a NaN and shows in the cost.
        k = first + min(i, n - 1)
        dx, dy, dz = points[k, 0] - c[0], points[k, 1] - c[1], points[k, 2] - c[2]
        m[at.X + i] = away_from_zero(R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz)
        m[at.Y + i] = away_from_zero(R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz)
        m[at.Z + i] = away_from_zero(R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz)
    compute_radial_rows(shape, tapered, work, lanes)
    _differentiate_distances(shape.exponents, shape.taper, m, lanes)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _differentiate_distances(exponents, taper, m, lanes):
    """Write residuals and derivatives from the rows of the radial scale."""
    k1, k2 = 2.0 / exponents[0], 2.0 / exponents[1]
    for i in range(lanes):
        x, y, z = m[at.X + i], m[at.Y + i], m[at.Z + i]
        over_x, over_y, over_z = 1.0 / x, 1.0 / y, 1.0 / z
        ax, ay, s, t = m[at.LOG_X + i], m[at.LOG_Y + i], m[at.LOG_Z + i], m[at.SECTION_TERM + i]
        log_a, log_f, inv_g = m[at.LOG_A + i], m[at.LOG_F + i], m[at.INV_G + i]
        slope, over1, over2 = m[at.HEIGHT_SLOPE + i], m[at.INV_WIDTH_X + i], m[at.INV_WIDTH_Y + i]
        lean1, lean2 = taper[0] * slope * over1, taper[1] * slope * over2
        w, w3, u1, u2 = (
            m[at.SHARE_XY + i],
            m[at.SHARE_HEIGHT + i],
            m[at.SHARE_X + i],
            m[at.SHARE_Y + i],
        )
        p1, p2, p3 = w * u1, w * u2, w3
        # ∇h: a step along z also moves between sections.
        g1, g2 = p1 * over_x, p2 * over_y
        g3 = p3 * over_z - p1 * lean1 - p2 * lean2
        over_n = 1.0 / np.sqrt(g1 * g1 + g2 * g2 + g3 * g3)
        r = (1.0 - inv_g) * over_n
        along, across = inv_g * over_n, r * over_n
        m[at.RESIDUAL + i] = r
        # d: derivatives of the shares by the logarithms of the coordinates (symmetric).
        # m1 to m3: ∂n/∂p. r changes with a share by -across times that.
        q, o = w * w3 * k1, w * k2 * u1 * u2
        d11, d12, d13 = q * u1 * u1 + o, q * u1 * u2 - o, -q * u1
        d22, d23, d33 = q * u2 * u2 + o, -q * u2, q
        n1, n2, n3 = g1 * over_n, g2 * over_n, g3 * over_n
        m1, m2, m3 = n1 * over_x - n3 * lean1, n2 * over_y - n3 * lean2, n3 * over_z
        r1 = along * p1 - across * (m1 * d11 + m2 * d12 + m3 * d13)
        r2 = along * p2 - across * (m1 * d12 + m2 * d22 + m3 * d23)
        r3 = along * p3 - across * (m1 * d13 + m2 * d23 + m3 * d33)
        m[i], m[LANES + i] = -r1, -r2
        entropy = log_a - u1 * ax - u2 * ay
        dw = w * w3 * (s - t) * (0.5 * k1)
        m[3 * LANES + i] = along * 0.5 * (log_f - w * t - w3 * s) - across * dw * (
            m1 * u1 + m2 * u2 - m3
        )
        dw = w * w3 * entropy * (0.5 * k1)
        du = -u1 * u2 * (ax - ay) * (0.5 * k2)
        m[4 * LANES + i] = along * 0.5 * w * entropy - across * (
            m1 * (dw * u1 + w * du) + m2 * (dw * u2 - w * du) - m3 * dw
        )
        v1 = (r1 + across * n1 * p1 * over_x) * over_x
        v2 = (r2 + across * n2 * p2 * over_y) * over_y
        v3 = (r3 + across * n3 * p3 * over_z) * over_z
        # Without a taper, and beyond its reach, lean1 and lean2 are 0.
        bend = n3 * (p1 * lean1 * lean1 + p2 * lean2 * lean2)
        leaning = r1 * lean1 + r2 * lean2 + across * bend
        v3 -= leaning
        m[2 * LANES + i] = leaning * z - r3 - across * n3 * (p1 * lean1 + p2 * lean2)
        height, pull = m[at.HEIGHT + i], across * n3 * slope
        m[11 * LANES + i] = over1 * (pull * p1 * over1 - r1 * height)
        m[12 * LANES + i] = over2 * (pull * p2 * over2 - r2 * height)
        m[5 * LANES + i] = v2 * z - v3 * y
        m[6 * LANES + i] = v3 * x - v1 * z
        m[7 * LANES + i] = v1 * y - v2 * x
        m[8 * LANES + i], m[9 * LANES + i], m[10 * LANES + i] = -v1, -v2, -v3


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def add_points(weights, first, n, scale, count, work, gradient, hessian):
    """Add a batch of points to gradient (13,) and Hessian (13, 13) under the Cauchy loss.

    Parameters
    ----------
    weights
        (N,) of all points.
    first, n, work
        As for :func:`compute_distance_rows`, which has filled `work`.
    scale
        Scale of the loss.
    count
        Number of derivatives in use: N_PARAMETERS or N_STRAIGHT.

    Returns
    -------
    float
        The cost of these points.
    """
    lanes = lane_count(n)
    over = 1.0 / scale
    m = work.flat
    for i in range(lanes):
        m[_SQUARE + i] = (m[at.RESIDUAL + i] * over) ** 2
    log1p_row(work.grid, work.bits, _SQUARE_ROW, _LOSS_ROW, at.SPARE_ROW, lanes)
    for i in range(lanes):
        m[_WEIGHT + i] = weights[first + i] if i < n else 0.0
    cost = 0.0
    for i in range(lanes):
        cost += m[_WEIGHT + i] * m[_LOSS + i]
        m[_SLOPE + i] = m[_WEIGHT + i] / (1.0 + m[_SQUARE + i])
    _add_rows(count, work, lanes, gradient, hessian)
    return 0.5 * scale * scale * cost


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def add_rays(weight, pull, scale, n, count, work, gradient, hessian):
    """Add a batch of rays to gradient (13,) and Hessian (13, 13).

    Parameters
    ----------
    weight
        Weight of one ray.
    pull
        Share of the weight of rays that pass outside, which take the Cauchy loss.
    scale
        Scale of that loss.
    n, count, work
        As for :func:`add_points`.

    Returns
    -------
    float
        The cost of these rays.
    """
    lanes = lane_count(n)
    over = 1.0 / scale
    grid = work.grid
    for i in range(lanes):
        grid[_SQUARE_ROW, i] = (grid[at.RESIDUAL_ROW, i] * over) ** 2
    log1p_row(grid, work.bits, _SQUARE_ROW, _LOSS_ROW, at.SPARE_ROW, lanes)
    cost = 0.0
    for i in range(lanes):
        depth = grid[at.RESIDUAL_ROW, i] if i < n else 0.0
        if depth > 0.0:
            cost += 0.5 * weight * depth * depth
            grid[_SLOPE_ROW, i] = weight
        elif depth < 0.0:
            cost += 0.5 * weight * pull * scale * scale * grid[_LOSS_ROW, i]
            grid[_SLOPE_ROW, i] = weight * pull / (1.0 + grid[_SQUARE_ROW, i])
        else:
            grid[_SLOPE_ROW, i] = 0.0
    _add_rows(count, work, lanes, gradient, hessian)
    return cost


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _add_rows(count, work, lanes, gradient, hessian):
    """Add the weighted residuals and derivatives in the working memory."""
    m, grid = work.flat, work.grid
    for j in range(count):
        for i in range(lanes):
            m[_SCALED + i] = m[_SLOPE + i] * grid[j, i]
        slope = 0.0
        for i in range(lanes):
            slope += m[_SCALED + i] * m[at.RESIDUAL + i]
        gradient[j] += slope
        for k in range(j + 1):
            product = 0.0
            for i in range(lanes):
                product += m[_SCALED + i] * grid[k, i]
            hessian[j, k] += product

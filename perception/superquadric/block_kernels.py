"""Compiled residuals of many points at a time, and what a robust sum of squares makes of them.

The residual of a point is its first-order normal distance r = (G - 1)/‖∇G‖ with the gauge
G = F^(ε1/2) (Sampson 1982 on the function of Solina and Bajcsy 1990). With h = log G, shares
p = ∂h/∂(log x, log y, log z) and n = ‖∇h‖ it reads r = (1 - e^-h)/n: all in logarithms, so that
exponents down to 0.02 neither overflow nor lose digits.

Every quantity of a block of points is a row of LANES numbers in one piece of memory, each row at
a constant place: so the compiler sees that no row overlaps another, and computes several points
with each instruction, in a third of the time of one point after the other.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .gauge import TAPER_REACH
from .gauge_kernels import FAST, SMALL
from .vector_kernels import exp_all, log1p_all, log_all

PARAMETERS = 13
"""Length of the full parameter vector."""
STRAIGHT = 11
"""Parameters before the taper's: what solids without one can move."""
LANES = 64
"""Points of a block: eight cache lines a row, so that all rows stay in the nearest cache."""

R_ROW = PARAMETERS * LANES
"""Where the residuals are; before them, row by row, their derivatives."""
(
    _X,
    _Y,
    _Z,
    _LX,
    _LY,
    _LZ,
    _HEIGHT,
    _RISE,
    _OVER1,
    _OVER2,
    _RATIO,
    _MORE,
    _LOG_A,
    _U1,
    _U2,
    _T,
    _LOG_F,
    _W,
    _W3,
    _FALLING,
    _SLOPE,
    _SCALED,
    _SPARE,
) = range(R_ROW + LANES, R_ROW + 24 * LANES, LANES)
# Once the logarithms are taken, they make way for what comes of them.
_AX, _AY, _S = _LX, _LY, _LZ
MEMORY = _SPARE + 3 * LANES
"""Numbers of working memory for a block."""
_LOGS = 3 * LANES


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def distance_rows(points, first, n, R, c, axes, eps, taper, tapered, m):
    """Residuals of points ``first`` to ``first + n`` and their derivatives.

    Parameters
    ----------
    points
        (N, 3) cloud.
    first, n
        Which of them, at most LANES; the last one fills the block.
    R, c, axes, eps, taper, tapered
        As in :func:`~.residual_kernels.normal_equations`.
    m
        (MEMORY,), written: row k of derivatives begins at ``k * LANES``, those of the taper only
        where it is `tapered`; residuals begin at R_ROW.
    """
    for i in range(LANES):
        k = first + min(i, n - 1)
        dx, dy, dz = points[k, 0] - c[0], points[k, 1] - c[1], points[k, 2] - c[2]
        m[_X + i] = R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz
        m[_Y + i] = R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz
        m[_Z + i] = R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz
    for i in range(_X, _X + _LOGS):
        if abs(m[i]) < SMALL:
            m[i] = SMALL if m[i] >= 0.0 else -SMALL
    if tapered:
        over_a3 = np.exp(-axes[2])
        for i in range(LANES):
            t = m[_Z + i] * over_a3
            height = min(max(t, -TAPER_REACH), TAPER_REACH)
            m[_HEIGHT + i] = height
            m[_RISE + i] = over_a3 if height == t else 0.0
            m[_OVER1 + i] = 1.0 / (1.0 + taper[0] * height)
            m[_OVER2 + i] = 1.0 / (1.0 + taper[1] * height)
            m[_LX + i] = abs(m[_X + i] * m[_OVER1 + i])
            m[_LY + i] = abs(m[_Y + i] * m[_OVER2 + i])
            m[_LZ + i] = abs(m[_Z + i])
    else:
        for i in range(LANES):
            m[_HEIGHT + i], m[_RISE + i] = 0.0, 0.0
            m[_OVER1 + i], m[_OVER2 + i] = 1.0, 1.0
        for i in range(_LOGS):
            m[_LX + i] = abs(m[_X + i])
    spare = m[_SPARE : _SPARE + _LOGS]
    logs = m[_LX : _LX + _LOGS]
    log_all(logs, logs, spare)

    e1, e2 = eps[0], eps[1]
    k1, k2 = 2.0 / e1, 2.0 / e2
    ratio, more, rest = (
        m[_RATIO : _RATIO + LANES],
        m[_MORE : _MORE + LANES],
        m[_FALLING : _FALLING + LANES],
    )
    for i in range(LANES):
        ax, ay = k2 * (m[_LX + i] - axes[0]), k2 * (m[_LY + i] - axes[1])
        m[_AX + i], m[_AY + i] = ax, ay
        m[_S + i] = k1 * (m[_LZ + i] - axes[2])
        m[_RATIO + i] = -abs(ax - ay)
    exp_all(ratio, ratio, spare)
    log1p_all(ratio, more, spare)
    for i in range(LANES):
        ax, ay = m[_AX + i], m[_AY + i]
        log_a = max(ax, ay) + m[_MORE + i]
        large = 1.0 / (1.0 + m[_RATIO + i])
        small = m[_RATIO + i] * large
        t = e2 * 0.5 * k1 * log_a
        m[_LOG_A + i], m[_T + i] = log_a, t
        m[_U1 + i] = large if ax > ay else small
        m[_U2 + i] = small if ax > ay else large
        m[_RATIO + i] = -abs(t - m[_S + i])
    exp_all(ratio, ratio, spare)
    log1p_all(ratio, more, spare)
    for i in range(LANES):
        t, s = m[_T + i], m[_S + i]
        log_f = max(t, s) + m[_MORE + i]
        large = 1.0 / (1.0 + m[_RATIO + i])
        small = m[_RATIO + i] * large
        m[_LOG_F + i] = log_f
        m[_W + i] = large if t > s else small
        m[_W3 + i] = small if t > s else large
        m[_FALLING + i] = -0.5 * e1 * log_f
    exp_all(rest, rest, spare)

    for i in range(LANES):
        x, y, z = m[_X + i], m[_Y + i], m[_Z + i]
        over_x, over_y, over_z = 1.0 / x, 1.0 / y, 1.0 / z
        ax, ay, s, t = m[_AX + i], m[_AY + i], m[_S + i], m[_T + i]
        log_a, log_f, falling = m[_LOG_A + i], m[_LOG_F + i], m[_FALLING + i]
        rise, over1, over2 = m[_RISE + i], m[_OVER1 + i], m[_OVER2 + i]
        lean1, lean2 = taper[0] * rise * over1, taper[1] * rise * over2
        w, w3, u1, u2 = m[_W + i], m[_W3 + i], m[_U1 + i], m[_U2 + i]
        p1, p2, p3 = w * u1, w * u2, w3
        # ∇h: a step along z also moves between sections.
        g1, g2 = p1 * over_x, p2 * over_y
        g3 = p3 * over_z - p1 * lean1 - p2 * lean2
        over_n = 1.0 / np.sqrt(g1 * g1 + g2 * g2 + g3 * g3)
        r = (1.0 - falling) * over_n
        along, across = falling * over_n, r * over_n
        m[R_ROW + i] = r
        # The shares' derivatives and m = ∂n/∂p, as in `distance_row`.
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
        height, pull = m[_HEIGHT + i], across * n3 * rise
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
    over = 1.0 / scale
    for i in range(LANES):
        m[_RATIO + i] = (m[R_ROW + i] * over) ** 2
    log1p_all(m[_RATIO : _RATIO + LANES], m[_MORE : _MORE + LANES], m[_SPARE : _SPARE + LANES])
    for i in range(LANES):
        m[_W + i] = weights[first + i] if i < n else 0.0
    cost = 0.0
    for i in range(LANES):
        cost += m[_W + i] * m[_MORE + i]
        m[_SLOPE + i] = m[_W + i] / (1.0 + m[_RATIO + i])
    for j in range(count):
        falls = 0.0
        row = m[j * LANES : (j + 1) * LANES]
        for i in range(LANES):
            m[_SCALED + i] = m[_SLOPE + i] * row[i]
        for i in range(LANES):
            falls += m[_SCALED + i] * m[R_ROW + i]
        gradient[j] += falls
        for k in range(j + 1):
            other = m[k * LANES : (k + 1) * LANES]
            product = 0.0
            for i in range(LANES):
                product += m[_SCALED + i] * other[i]
            hessian[j, k] += product
    return 0.5 * scale * scale * cost

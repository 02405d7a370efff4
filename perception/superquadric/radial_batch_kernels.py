"""Compiled gauge of many places at a time: their logarithms, and the shares of the coordinates.

Every quantity is a row of LANES numbers in one piece of memory, each row at a constant place: so
the compiler sees that no row overlaps another, and computes several places with each instruction,
in a third of the time of one after the other.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .radial_kernels import FAST
from .radial_scale import TAPER_REACH
from .vector_kernels import exp_row, log1p_row, log_row

LANES = 64
"""Numbers of a row: eight cache lines, so that all rows stay in the nearest cache."""
STEP = 16
"""Rows are computed in steps of so many lanes: what the compiler takes at once."""
PARAMETERS = 13
"""Length of the full parameter vector."""
STRAIGHT = 11
"""Parameters before the taper's: what solids without one can move."""

R_ROW = PARAMETERS
"""Row of residuals; the rows before it are their derivatives, by parameter."""
X_ROW, Y_ROW, Z_ROW = 14, 15, 16
"""Rows of the coordinates along the solid's own axes, not 0."""
_LX, _LY, _LZ = 17, 18, 19
HEIGHT_ROW, RISE_ROW, OVER1_ROW, OVER2_ROW = 20, 21, 22, 23
"""Height over a3 at which the taper is taken, its slope by z, and 1 over the widths there."""
_RATIO, _MORE = 24, 25
LOG_A_ROW, U1_ROW, U2_ROW, T_ROW = 26, 27, 28, 29
"""Logarithm of the section's sum, the shares of x and y in it, and the first term of log F."""
LOG_F_ROW, W_ROW, W3_ROW, FALLING_ROW = 30, 31, 32, 33
"""Log F, the shares of the section and of z in it, and 1/G."""
SPARE_ROW, FREE_ROW = 34, 35
"""A row that logarithms overwrite, and the first of those that no function here touches."""
ROWS = 48
"""Rows of working memory."""
# Once the logarithms are taken, they make way for what comes of them.
AX_ROW, AY_ROW, S_ROW = _LX, _LY, _LZ
"""Scaled logarithms of x, y and z: the terms of both sums."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def lanes_for(n):
    """Lanes to compute for n <= LANES places."""
    return min((n + STEP - 1) // STEP * STEP, LANES)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def gauge_rows(axes, eps, taper, tapered, m, grid, bits, lanes):
    """Write everything that the gauge is made of, from the coordinates' rows.

    Parameters
    ----------
    axes, eps, taper, tapered
        As in :func:`~.residual_kernels.normal_equations`.
    m
        (ROWS * LANES,) working memory; row k begins at ``k * LANES``.
    grid, bits
        The same memory as (ROWS, LANES), and that as int64.
    lanes
        How many lanes to compute, at most LANES.
    """
    X, Y, Z = X_ROW * LANES, Y_ROW * LANES, Z_ROW * LANES
    LX, LY, LZ = _LX * LANES, _LY * LANES, _LZ * LANES
    HEIGHT, RISE = HEIGHT_ROW * LANES, RISE_ROW * LANES
    OVER1, OVER2 = OVER1_ROW * LANES, OVER2_ROW * LANES
    if tapered:
        over_a3 = np.exp(-axes[2])
        for i in range(lanes):
            share = m[Z + i] * over_a3
            height = min(max(share, -TAPER_REACH), TAPER_REACH)
            m[HEIGHT + i] = height
            m[RISE + i] = over_a3 if height == share else 0.0
            m[OVER1 + i] = 1.0 / (1.0 + taper[0] * height)
            m[OVER2 + i] = 1.0 / (1.0 + taper[1] * height)
    else:
        for i in range(lanes):
            m[HEIGHT + i], m[RISE + i] = 0.0, 0.0
            m[OVER1 + i], m[OVER2 + i] = 1.0, 1.0
    for i in range(lanes):
        m[LX + i] = abs(m[X + i] * m[OVER1 + i])
        m[LY + i] = abs(m[Y + i] * m[OVER2 + i])
        m[LZ + i] = abs(m[Z + i])
    log_row(grid, bits, _LX, SPARE_ROW, lanes)
    log_row(grid, bits, _LY, SPARE_ROW, lanes)
    log_row(grid, bits, _LZ, SPARE_ROW, lanes)

    k1, k2 = 2.0 / eps[0], 2.0 / eps[1]
    RATIO, MORE = _RATIO * LANES, _MORE * LANES
    for i in range(lanes):
        ax, ay = k2 * (m[LX + i] - axes[0]), k2 * (m[LY + i] - axes[1])
        m[LX + i], m[LY + i] = ax, ay
        m[LZ + i] = k1 * (m[LZ + i] - axes[2])
        m[RATIO + i] = -abs(ax - ay)
    exp_row(grid, bits, _RATIO, SPARE_ROW, lanes)
    log1p_row(grid, bits, _RATIO, _MORE, SPARE_ROW, lanes)
    LOG_A, U1, U2, T = LOG_A_ROW * LANES, U1_ROW * LANES, U2_ROW * LANES, T_ROW * LANES
    for i in range(lanes):
        ax, ay = m[LX + i], m[LY + i]
        log_a = max(ax, ay) + m[MORE + i]
        large = 1.0 / (1.0 + m[RATIO + i])
        small = m[RATIO + i] * large
        t = eps[1] * 0.5 * k1 * log_a
        m[LOG_A + i], m[T + i] = log_a, t
        m[U1 + i] = large if ax > ay else small
        m[U2 + i] = small if ax > ay else large
        m[RATIO + i] = -abs(t - m[LZ + i])
    exp_row(grid, bits, _RATIO, SPARE_ROW, lanes)
    log1p_row(grid, bits, _RATIO, _MORE, SPARE_ROW, lanes)
    LOG_F, W, W3, FALLING = (
        LOG_F_ROW * LANES,
        W_ROW * LANES,
        W3_ROW * LANES,
        FALLING_ROW * LANES,
    )
    for i in range(lanes):
        t, s = m[T + i], m[LZ + i]
        log_f = max(t, s) + m[MORE + i]
        large = 1.0 / (1.0 + m[RATIO + i])
        small = m[RATIO + i] * large
        m[LOG_F + i] = log_f
        m[W + i] = large if t > s else small
        m[W3 + i] = small if t > s else large
        m[FALLING + i] = -0.5 * eps[0] * log_f
    exp_row(grid, bits, FALLING_ROW, SPARE_ROW, lanes)

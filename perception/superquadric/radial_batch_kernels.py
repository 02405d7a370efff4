"""Compiled radial scale G of a batch of points, and the shares of the coordinates in log G.

The rows of the working memory are listed in :mod:`work_rows`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from . import work_rows as at
from .radial_scale import TAPER_REACH
from .vector_kernels import exp_row, log1p_row, log_row
from .work_rows import FAST_MATH


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def compute_radial_rows(shape, tapered, work, lanes):
    """Compute rows LOG_X to INV_G of the working memory from the coordinates in X, Y, Z.

    Parameters
    ----------
    shape
        :class:`~.parameters.ShapeParameters`.
    tapered
        Whether the taper of `shape` is applied.
    work
        :class:`~.work_rows.Workspace`.
    lanes
        Number of lanes to compute, at most LANES.
    """
    _undo_taper(shape, tapered, work.flat, lanes)
    _sum_section_terms(shape, work, lanes)
    _sum_section_and_height(shape, work, lanes)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _undo_taper(shape, tapered, m, lanes):
    """Compute the rows of the taper, HEIGHT to INV_WIDTH_Y, and the straight coordinates.

    The absolute straight coordinates go to the rows LOG_X, LOG_Y, LOG_Z.
    """
    if tapered:
        inv_a3 = np.exp(-shape.log_axes[2])
        for i in range(lanes):
            relative_z = m[at.Z + i] * inv_a3
            height = min(max(relative_z, -TAPER_REACH), TAPER_REACH)
            m[at.HEIGHT + i] = height
            m[at.HEIGHT_SLOPE + i] = inv_a3 if height == relative_z else 0.0
            m[at.INV_WIDTH_X + i] = 1.0 / (1.0 + shape.taper[0] * height)
            m[at.INV_WIDTH_Y + i] = 1.0 / (1.0 + shape.taper[1] * height)
    else:
        for i in range(lanes):
            m[at.HEIGHT + i], m[at.HEIGHT_SLOPE + i] = 0.0, 0.0
            m[at.INV_WIDTH_X + i], m[at.INV_WIDTH_Y + i] = 1.0, 1.0
    for i in range(lanes):
        m[at.LOG_X + i] = abs(m[at.X + i] * m[at.INV_WIDTH_X + i])
        m[at.LOG_Y + i] = abs(m[at.Y + i] * m[at.INV_WIDTH_Y + i])
        m[at.LOG_Z + i] = abs(m[at.Z + i])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _sum_section_terms(shape, work, lanes):
    """Compute the scaled logarithms, LOG_A, SHARE_X, SHARE_Y and SECTION_TERM.

    RATIO receives the logarithm of the smaller over the larger term of F, for
    :func:`_sum_section_and_height`.
    """
    m, grid, bits = work.flat, work.grid, work.bits
    log_row(grid, bits, at.LOG_X_ROW, at.SPARE_ROW, lanes)
    log_row(grid, bits, at.LOG_Y_ROW, at.SPARE_ROW, lanes)
    log_row(grid, bits, at.LOG_Z_ROW, at.SPARE_ROW, lanes)
    log_axes, exponents = shape.log_axes, shape.exponents
    k1, k2 = 2.0 / exponents[0], 2.0 / exponents[1]
    for i in range(lanes):
        ax, ay = k2 * (m[at.LOG_X + i] - log_axes[0]), k2 * (m[at.LOG_Y + i] - log_axes[1])
        m[at.LOG_X + i], m[at.LOG_Y + i] = ax, ay
        m[at.LOG_Z + i] = k1 * (m[at.LOG_Z + i] - log_axes[2])
        m[at.RATIO + i] = -abs(ax - ay)
    exp_row(grid, bits, at.RATIO_ROW, at.SPARE_ROW, lanes)
    log1p_row(grid, bits, at.RATIO_ROW, at.LOG1P_ROW, at.SPARE_ROW, lanes)
    for i in range(lanes):
        ax, ay = m[at.LOG_X + i], m[at.LOG_Y + i]
        log_a = max(ax, ay) + m[at.LOG1P + i]
        large = 1.0 / (1.0 + m[at.RATIO + i])
        small = m[at.RATIO + i] * large
        term = exponents[1] * 0.5 * k1 * log_a
        m[at.LOG_A + i], m[at.SECTION_TERM + i] = log_a, term
        m[at.SHARE_X + i] = large if ax > ay else small
        m[at.SHARE_Y + i] = small if ax > ay else large
        m[at.RATIO + i] = -abs(term - m[at.LOG_Z + i])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _sum_section_and_height(shape, work, lanes):
    """Compute LOG_F, SHARE_XY, SHARE_HEIGHT and INV_G."""
    m, grid, bits = work.flat, work.grid, work.bits
    exp_row(grid, bits, at.RATIO_ROW, at.SPARE_ROW, lanes)
    log1p_row(grid, bits, at.RATIO_ROW, at.LOG1P_ROW, at.SPARE_ROW, lanes)
    for i in range(lanes):
        t, s = m[at.SECTION_TERM + i], m[at.LOG_Z + i]
        log_f = max(t, s) + m[at.LOG1P + i]
        large = 1.0 / (1.0 + m[at.RATIO + i])
        small = m[at.RATIO + i] * large
        m[at.LOG_F + i] = log_f
        m[at.SHARE_XY + i] = large if t > s else small
        m[at.SHARE_HEIGHT + i] = small if t > s else large
        m[at.INV_G + i] = -0.5 * shape.exponents[0] * log_f
    exp_row(grid, bits, at.INV_G_ROW, at.SPARE_ROW, lanes)

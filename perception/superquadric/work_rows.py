"""Layout of the working memory in which the kernels process points and rays in batches.

The memory is one flat array of rows. Each row holds one quantity for up to LANES points or rays.
The constants here are the constant offsets of the rows in the flat array, so that the compiler
knows that rows do not overlap and vectorises the loops. That takes a third of the time of one
point after the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .parameters import N_PARAMETERS

FAST_MATH = {"contract", "reassoc", "arcp", "nsz"}
"""Optimisations that change rounding only; infinities and NaN keep their meaning."""
MIN_COORDINATE = 1e-7
"""Coordinates nearer to 0 are set to this, so that their logarithms stay finite."""

LANES = 64
"""Points of a batch: a row is eight cache lines, so that all rows fit the first-level cache."""
STEP = 16
"""Kernels round the number of points up to a multiple of this, for the vector instructions."""
ROWS = 48

# Rows 0 to 12 hold the derivatives of the residual by the full parameters.
RESIDUAL_ROW = N_PARAMETERS
RESIDUAL = RESIDUAL_ROW * LANES
X, Y, Z = 14 * LANES, 15 * LANES, 16 * LANES
"""Local coordinates, never 0."""
LOG_X_ROW, LOG_Y_ROW, LOG_Z_ROW = 17, 18, 19
LOG_X, LOG_Y, LOG_Z = LOG_X_ROW * LANES, LOG_Y_ROW * LANES, LOG_Z_ROW * LANES
"""Logarithms of the straight coordinates over the semi-axes, times 2/ε2, 2/ε2 and 2/ε1."""
HEIGHT, HEIGHT_SLOPE = 20 * LANES, 21 * LANES
"""z/a3 at which the taper is evaluated, and its derivative by z."""
INV_WIDTH_X, INV_WIDTH_Y = 22 * LANES, 23 * LANES
"""1 over the taper's widths of the section at this height."""
RATIO_ROW, LOG1P_ROW = 24, 25
RATIO, LOG1P = RATIO_ROW * LANES, LOG1P_ROW * LANES
LOG_A, SHARE_X, SHARE_Y = 26 * LANES, 27 * LANES, 28 * LANES
"""log(A) with A = |x/a1|^(2/ε2) + |y/a2|^(2/ε2), and the shares of both terms."""
SECTION_TERM = 29 * LANES
"""ε2/ε1 log(A): logarithm of the section's term in F."""
LOG_F, SHARE_XY, SHARE_HEIGHT = 30 * LANES, 31 * LANES, 32 * LANES
"""log(F), and the shares of the section's term and of the z term in F."""
INV_G_ROW = 33
INV_G = INV_G_ROW * LANES
"""1/G = F^(-ε1/2)."""
SPARE_ROW = 34
"""Overwritten by logarithms and exponentials."""
FIRST_FREE_ROW = 35
"""First row for quantities of the caller."""


class Workspace(NamedTuple):
    """Working memory of a batch: three views of the same numbers."""

    flat: NDArray[np.float64]
    """(ROWS * LANES,)."""
    grid: NDArray[np.float64]
    """(ROWS, LANES)."""
    bits: NDArray[np.int64]
    """(ROWS, LANES): bit patterns of the numbers."""


@njit(cache=True, nogil=True, error_model="numpy")
def new_workspace():
    """Allocate the working memory of a batch."""
    flat = np.empty(ROWS * LANES)
    grid = flat.reshape(ROWS, LANES)
    return Workspace(flat, grid, grid.view(np.int64))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def lane_count(n):
    """Return the number of lanes to compute for n <= LANES points."""
    return min((n + STEP - 1) // STEP * STEP, LANES)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def away_from_zero(x):
    """Move a coordinate to at least MIN_COORDINATE from 0, keeping its sign."""
    return (MIN_COORDINATE if x >= 0.0 else -MIN_COORDINATE) if abs(x) < MIN_COORDINATE else x

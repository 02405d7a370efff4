"""Spread of forces on the foam's surface over the tactels (tactile elements) below it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.special import erf

from eyehand.errors import InputError

from .foam_column import CELLS_PER_TACTEL

POINT_SPREAD_M = 0.0025
"""Standard deviation of the Gaussian image of a point force, m. It is half the default pitch, so
that two to three tactels share the force. With a smaller spread, the tactels no longer show the
position of a probe between them."""

_FOLDS = 1
"""Number of mirror images of the row on each side. One is enough, because the pad is far wider than
the spread."""


def spread_weights(tactels: int, pitch: float, sigma: float) -> NDArray[np.float64]:
    """Compute the share of a grid cell's force that each tactel of a row bears.

    The image of a point force is a Gaussian of standard deviation `sigma`, and a tactel bears its
    integral over the pitch (differences of erf). The force grid already spreads the force by a
    quadratic B-spline of variance (cell width)^2 / 4. The Gaussian here has the remaining variance,
    sigma^2 minus that.

    Parameters
    ----------
    tactels
        Tactels in a row, >= 1.
    pitch
        Distance between their centres, m.
    sigma
        Standard deviation of the whole spread, m.

    Returns
    -------
    NDArray
        (tactels, CELLS_PER_TACTEL * tactels). Columns add up to 1, because force beyond the border
        is reflected into the pad.

    Raises
    ------
    InputError
        If `sigma` is not greater than the standard deviation of the force grid's spread.
    """
    cell = pitch / CELLS_PER_TACTEL
    if not sigma > 0.5 * cell:
        raise InputError(
            f"spread must be > {0.5 * cell} m (pitch / {2 * CELLS_PER_TACTEL}), got {sigma}"
        )
    scale = np.sqrt(2.0 * (sigma**2 - 0.25 * cell**2))
    length = tactels * pitch
    sources = (np.arange(CELLS_PER_TACTEL * tactels) + 0.5) * cell
    borders = np.arange(tactels + 1) * pitch
    weights = np.zeros((tactels, sources.size))
    for fold in range(-_FOLDS, _FOLDS + 1):
        for image in (2 * fold * length + sources, 2 * fold * length - sources):
            weights += 0.5 * np.diff(erf((borders[:, None] - image) / scale), axis=0)
    return weights / weights.sum(axis=0)


@njit(cache=True)
def spread_to_tactels(grid, across, down, area, pressures, shear):
    """Spread the forces of the grid to the tactels.

    Parameters
    ----------
    grid
        Force grid, (3, CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns), N (see
        :func:`solid_contact.press_solids`).
    across, down
        (columns, CELLS_PER_TACTEL * columns) and (rows, CELLS_PER_TACTEL * rows) float64, from
        :func:`spread_weights`.
    area
        Area of a tactel, m².
    pressures
        (rows * columns,) float64, overwritten, Pa.
    shear
        (rows * columns, 2) float64, overwritten, Pa along x and y.
    """
    rows, columns = len(down), len(across)
    line = np.empty(columns)
    total = np.empty((rows, columns))
    for channel in range(3):
        total[:] = 0.0
        for i in range(grid.shape[1]):
            first, last = _nonzero_range(grid[channel, i])
            if first > last:
                continue
            for c in range(columns):
                value = 0.0
                for j in range(first, last + 1):
                    value += across[c, j] * grid[channel, i, j]
                line[c] = value
            for r in range(rows):
                weight = down[r, i] / area
                for c in range(columns):
                    total[r, c] += weight * line[c]
        flat = total.reshape(-1)
        if channel == 0:
            pressures[:] = flat
        else:
            shear[:, channel - 1] = flat


@njit(cache=True)
def _nonzero_range(line):
    """Return the first and last cell that is not zero; first > last if all are zero."""
    first, last = 0, len(line) - 1
    while first <= last and line[first] == 0.0:
        first += 1
    while last >= first and line[last] == 0.0:
        last -= 1
    return first, last

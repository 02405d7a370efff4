"""How a force in the foam's surface spreads over the tactels below it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit
from scipy.special import erf

from eyehand.errors import InputError

from .foam_column import FINE

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FOLDS = 1
"""Mirror images on each side: the pad is far wider than the spread."""


def spread_weights(tactels: int, pitch: float, sigma: float) -> NDArray[np.float64]:
    """Give the share of a fine cell's force that each tactel of a row bears.

    A point force is felt as a Gaussian of standard deviation `sigma`; a tactel bears its integral
    over the pitch (differences of erf). The fine grid has spread the force already, by a
    quadratic B-spline of variance (cell width)^2 / 4, so the Gaussian here makes up the rest.

    Parameters
    ----------
    tactels
        Tactels in a row, >= 1.
    pitch
        Between their centres, m.
    sigma
        Standard deviation of the whole spread, m.

    Returns
    -------
    NDArray
        (tactels, FINE * tactels); columns add up to 1, for what would leave the pad is folded
        back at its border.

    Raises
    ------
    InputError
        If the spread is narrower than the fine grid's own.
    """
    cell = pitch / FINE
    if not sigma > 0.5 * cell:
        raise InputError(f"spread must be > {0.5 * cell} m (pitch / {2 * FINE}), got {sigma}")
    rest = np.sqrt(2.0 * (sigma**2 - 0.25 * cell**2))
    length = tactels * pitch
    sources = (np.arange(FINE * tactels) + 0.5) * cell
    borders = np.arange(tactels + 1) * pitch
    weights = np.zeros((tactels, sources.size))
    for fold in range(-_FOLDS, _FOLDS + 1):
        for image in (2 * fold * length + sources, 2 * fold * length - sources):
            weights += 0.5 * np.diff(erf((borders[:, None] - image) / rest), axis=0)
    return weights / weights.sum(axis=0)


@njit(cache=True)
def spread_to_tactels(fine, across, down, area, pressures, shear):
    """Spread the fine grid's forces to the tactels.

    Parameters
    ----------
    fine
        (3, FINE * rows, FINE * columns) float64, N (see :func:`pad_kernels.press_bed`).
    across, down
        (columns, FINE * columns) and (rows, FINE * rows) float64 (see :func:`spread_weights`).
    area
        Of a tactel, m².
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
        for i in range(fine.shape[1]):
            first, last = _filled(fine[channel, i])
            if first > last:
                continue
            for c in range(columns):
                value = 0.0
                for j in range(first, last + 1):
                    value += across[c, j] * fine[channel, i, j]
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
def _filled(line):
    """First and last cell that is not zero; first > last if all are."""
    first, last = 0, len(line) - 1
    while first <= last and line[first] == 0.0:
        first += 1
    while last >= first and line[last] == 0.0:
        last -= 1
    return first, last

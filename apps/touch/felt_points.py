"""Compute points of a touched surface from one tactile image, with deconvolution of the foam."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.pad import CELLS_PER_TACTEL, Foam, spread_weights
from eyehand.errors import InputError
from eyehand.tactile import TactileImage

MIN_PRESSURE = 200.0
"""Minimum pressure of a point, Pa, slightly above the sensor's lower limit. A lower pressure may
come from the foam's spread, and its noise would appear as a spike."""
MIN_SHARE = 0.75
"""Minimum pressure of a cell as a fraction of the maximum in its neighbourhood. Cells beside a
narrow imprint measure the foam's spread and not the surface."""
ROUNDS = 10
"""Number of deconvolution rounds. After 5 a ridge is still too low, 30 do not improve the result,
and from 100 on noise appears as spikes."""
FLOOR = 5.0
"""Offset added to measured and predicted pressure before their division, Pa. Without it, the ratio
of small pressures would be noise."""


def felt_points(
    image: TactileImage, foam: Foam, spread: float | None = None
) -> NDArray[np.float64]:
    """Compute points of the touched surface.

    Each cell with about the pressure of its neighbours yields one point. The pressure determines
    its depth in the foam. Its lateral position is the centre of pressure of the 3 x 3
    neighbourhood: the cell's centre on a face, and between cells on an edge or a point.

    Without `spread`, the cells are the tactels. With `spread`, each tactel is divided into smaller
    cells, and the pressure before the foam's spread is estimated in them. The spread makes a
    narrow ridge appear too low.

    Parameters
    ----------
    image
        Pressures of a flat pad with a regular grid.
    foam
        Foam on the pad. Its undeformed surface is at z = 0 of the pad frame.
    spread
        Standard deviation of the Gaussian by which the foam spreads a point force, m. Without it,
        the image is not deconvolved.

    Returns
    -------
    NDArray
        Points (M, 3) in the pad frame, m.

    Raises
    ------
    InputError
        If the array is not a grid, or the spread is less than a quarter of the pitch.
    """
    array = image.array
    if array.grid is None:
        raise InputError("felt points need a pad with an even grid of tactels")
    grid = array.grid
    pressures = np.maximum(image.pressures, 0.0).reshape(grid)
    places = array.positions.reshape(*grid, 3)
    x, y = places[0, :, 0], places[:, 0, 1]
    border = 1
    if spread is not None:
        pressures = deconvolve(pressures, float(np.sqrt(array.area)), spread)
        x, y, border = _cell_centres(x), _cell_centres(y), CELLS_PER_TACTEL
    windows = _windows(pressures)
    felt = (pressures > MIN_PRESSURE) & (pressures >= MIN_SHARE * windows.max(axis=0))
    # The windows are incomplete at the border because nothing is measured beyond it.
    felt[:border] = felt[-border:] = felt[:, :border] = felt[:, -border:] = False
    total = np.maximum(windows.sum(axis=0), MIN_PRESSURE)
    across, down = ((windows * _windows(axis)).sum(axis=0) / total for axis in np.meshgrid(x, y))
    return np.column_stack([across[felt], down[felt], -foam.compression(pressures[felt])])


def deconvolve(
    pressures: NDArray[np.float64], pitch: float, spread: float, rounds: int = ROUNDS
) -> NDArray[np.float64]:
    """Estimate the pressure on the foam's surface before the foam spreads it to the tactels.

    Use Richardson-Lucy deconvolution (Richardson, J. Opt. Soc. Am. 62, 1972; Lucy, Astron. J. 79,
    1974). Each round multiplies the estimate by the back-projected ratio of measured to predicted
    pressure. The estimate stays non-negative, and few rounds keep the noise small.

    Parameters
    ----------
    pressures
        Measured pressures (rows, columns), Pa, >= 0.
    pitch
        Distance between tactels, m.
    spread
        Standard deviation of the Gaussian by which the foam spreads a point force, m.
    rounds
        Number of rounds. More rounds give a sharper and noisier result.

    Returns
    -------
    NDArray
        (CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns), Pa.

    Raises
    ------
    InputError
        If the spread is less than a quarter of the pitch.
    """
    rows, columns = pressures.shape
    # The weights form means, not sums: without spread, a tactel measures the mean of its cells.
    down = _weights(rows, pitch, spread)
    right = _weights(columns, pitch, spread).T
    weight = down.sum(axis=0)[:, None] * right.sum(axis=1)
    estimate = np.kron(pressures + FLOOR, np.ones((CELLS_PER_TACTEL, CELLS_PER_TACTEL)))
    for _ in range(rounds):
        ratio = (pressures + FLOOR) / (down @ estimate @ right)
        estimate = estimate * (down.T @ ratio @ right.T) / weight
    return np.maximum(estimate - FLOOR, 0.0)


@cache
def _weights(tactels: int, pitch: float, spread: float) -> NDArray[np.float64]:
    return spread_weights(tactels, pitch, spread) / CELLS_PER_TACTEL


def _cell_centres(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centres of the grid cells within tactels with these centres (N,)."""
    pitch = places[1] - places[0]
    within = ((np.arange(CELLS_PER_TACTEL) + 0.5) / CELLS_PER_TACTEL - 0.5) * pitch
    return (places[:, None] + within).ravel()


def _windows(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the 3 x 3 neighbourhood of each cell (9, rows, columns), zero beyond the border."""
    padded = np.pad(values, 1)
    rows, columns = values.shape
    return np.array([padded[r : r + rows, c : c + columns] for r in range(3) for c in range(3)])

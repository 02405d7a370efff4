"""Points of a touched surface from one tactile image, freed of what the foam blurs."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.pad import CELLS_PER_TACTEL, spread_weights
from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.pad import Foam
    from eyehand.tactile import TactileImage

MIN_PRESSURE = 200.0
"""A little over where the sensor's range begins, Pa; less may be what the foam spreads from
beside, and its noise drawn as a spike."""
MIN_SHARE = 0.75
"""Of the highest pressure among the neighbours that a cell must bear: beside a narrow imprint
cells feel what the foam spreads, not the surface."""
ROUNDS = 10
"""Of undoing the spread: after 5 a ridge is still read lower, 30 gain nothing, and from 100 on
noise is drawn as spikes."""
FLOOR = 5.0
"""Added to what is felt and to what is foretold before the two are compared, Pa: near to no
pressure their ratio would be that of the noise."""


def felt_points(
    image: TactileImage, foam: Foam, spread: float | None = None
) -> NDArray[np.float64]:
    """Give points of the touched surface.

    Each cell that bears about as much as its neighbours gives one: as deep in the foam as its
    pressure says, and across at the centre of pressure of its 3 x 3 neighbourhood, which for a
    face is the cell's own place and for an edge or a point is between cells.

    Cells are the tactels, or, where the foam's spread is told, quarters of them, in which the
    pressure before the spread is sought: a tactel bears its neighbours' share of what is felt
    beside it, so that a narrow ridge looks lower than it is.

    Parameters
    ----------
    image
        Pressures, of a flat pad with an even grid.
    foam
        What covers the pad, undeformed 0 at the frame's z.
    spread
        Standard deviation of the Gaussian that a point force is felt as, m; left in the image
        when not given.

    Returns
    -------
    NDArray
        (M, 3), in the pad's frame, m.

    Raises
    ------
    InputError
        If the array is no grid, or the spread narrower than a quarter of the pitch.
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
        pressures = unspread(pressures, float(np.sqrt(array.area)), spread)
        x, y, border = _finer(x), _finer(y), CELLS_PER_TACTEL
    windows = _windows(pressures)
    felt = (pressures > MIN_PRESSURE) & (pressures >= MIN_SHARE * windows.max(axis=0))
    # At the border the windows are cut, and what lies beyond is not felt.
    felt[:border] = felt[-border:] = felt[:, :border] = felt[:, -border:] = False
    total = np.maximum(windows.sum(axis=0), MIN_PRESSURE)
    across, down = ((windows * _windows(axis)).sum(axis=0) / total for axis in np.meshgrid(x, y))
    return np.column_stack([across[felt], down[felt], -foam.compression(pressures[felt])])


def unspread(
    pressures: NDArray[np.float64], pitch: float, spread: float, rounds: int = ROUNDS
) -> NDArray[np.float64]:
    """Give the pressure that the foam's surface bore before it spread to the tactels.

    By rounds of Richardson's and Lucy's rule (Richardson, J. Opt. Soc. Am. 62, 1972; Lucy, Astron.
    J. 79, 1974): each multiplies what is sought by how far what it foretells falls short of what
    is felt, spread back. Nothing becomes negative, and stopping early keeps noise small.

    Parameters
    ----------
    pressures
        (rows, columns), Pa, >= 0.
    pitch
        Between tactels, m.
    spread
        Standard deviation of the Gaussian that a point force is felt as, m.
    rounds
        More are sharper and noisier.

    Returns
    -------
    NDArray
        (CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns), Pa.

    Raises
    ------
    InputError
        If the spread is narrower than a quarter of the pitch.
    """
    rows, columns = pressures.shape
    # Means, not sums: a tactel's pressure is the mean of its cells' where nothing spreads.
    down = _weights(rows, pitch, spread)
    right = _weights(columns, pitch, spread).T
    weight = down.sum(axis=0)[:, None] * right.sum(axis=1)
    sought = np.kron(pressures + FLOOR, np.ones((CELLS_PER_TACTEL, CELLS_PER_TACTEL)))
    for _ in range(rounds):
        ratio = (pressures + FLOOR) / (down @ sought @ right)
        sought = sought * (down.T @ ratio @ right.T) / weight
    return np.maximum(sought - FLOOR, 0.0)


@cache
def _weights(tactels: int, pitch: float, spread: float) -> NDArray[np.float64]:
    return spread_weights(tactels, pitch, spread) / CELLS_PER_TACTEL


def _finer(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the centres of the grid cells within tactels with these centres (N,)."""
    pitch = places[1] - places[0]
    within = ((np.arange(CELLS_PER_TACTEL) + 0.5) / CELLS_PER_TACTEL - 0.5) * pitch
    return (places[:, None] + within).ravel()


def _windows(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give each cell's 3 x 3 neighbours, (9, rows, columns), zeros beyond the border."""
    padded = np.pad(values, 1)
    rows, columns = values.shape
    return np.array([padded[r : r + rows, c : c + columns] for r in range(3) for c in range(3)])

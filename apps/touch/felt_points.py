"""Points of a touched surface from one tactile image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.foam import Foam
    from eyehand.tactile import TactileImage

LEAST_PRESSURE = 100.0
"""Where the sensor's range begins, Pa; less may be what the foam spreads from beside."""
LEAST_SHARE = 0.7
"""Of the highest pressure among the neighbours that a tactel must bear: beside a narrow imprint
tactels feel what the foam spreads, not the surface."""


def felt_points(image: TactileImage, foam: Foam) -> NDArray[np.float64]:
    """Give points of the touched surface.

    Each tactel that bears about as much as its neighbours gives one: as deep in the foam as its
    pressure says, and across at the centre of pressure of its 3 x 3 neighbourhood, which for a
    face is the tactel's own place and for an edge or a point is between tactels.

    Parameters
    ----------
    image
        Pressures, of a flat pad with an even grid.
    foam
        What covers the pad, undeformed 0 at the frame's z.

    Returns
    -------
    NDArray
        (M, 3), in the pad's frame, m.

    Raises
    ------
    InputError
        If the array is no grid.
    """
    if image.array.grid is None:
        raise InputError("felt points need a pad with an even grid of tactels")
    grid = image.array.grid
    pressures = np.maximum(image.pressures, 0.0).reshape(grid)
    places = image.array.positions.reshape(*grid, 3)
    windows = _windows(pressures)
    highest = windows.max(axis=0)
    felt = (pressures > LEAST_PRESSURE) & (pressures >= LEAST_SHARE * highest)
    # At the border the windows are cut, and what lies beyond is not felt.
    felt[[0, -1], :] = felt[:, [0, -1]] = False
    total = np.maximum(windows.sum(axis=0), LEAST_PRESSURE)
    x, y = ((windows * _windows(places[..., axis])).sum(axis=0) / total for axis in (0, 1))
    return np.column_stack([x[felt], y[felt], -foam.compression(pressures[felt])])


def _windows(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give each cell's 3 x 3 neighbours, (9, rows, columns), zeros beyond the border."""
    padded = np.pad(values, 1)
    rows, columns = values.shape
    return np.array([padded[r : r + rows, c : c + columns] for r in range(3) for c in range(3)])

"""In which direction the imprint shrinks: a plane through the areas felt on the way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEAST_SPREAD = 1e-3
"""Smallest share of the way's variance that must lie across it: on a straight way only one of the
slope's two components can be known. A weave of 0.6 rad has 0.01."""
CLEAR = 2.5
"""How many times its own standard error a slope must be to be followed."""
LEAST_CHANGE = 0.01
"""Smallest change of the area over one length, as a share of it, that is a slope: a face's imprint
changes less."""
LEAST_WAYS = 1.0
"""Way of evidence, in lengths, before there is a slope."""


class AreaSlope:
    """Least squares of area over place, older places weighing less.

    Parameters
    ----------
    length
        Way over which a place's weight falls to a third, m.
    """

    def __init__(self, length: float) -> None:
        self._length = length
        self._place = np.zeros(2)
        self._moved = self._way = 0.0
        self._normal = np.zeros((3, 3))
        self._right = np.zeros(3)
        self._squares = 0.0

    def move(self, way: NDArray[np.float64]) -> None:
        """Tell the motion since the last area, (2,), m."""
        self._place += way
        step = float(np.hypot(way[0], way[1]))
        self._moved += step
        self._way += step

    def update(self, area: float) -> NDArray[np.float64] | None:
        """Take an area, m², and give its slope over x and y, (2,), m; None while unclear."""
        keep = np.exp(-self._moved / self._length)
        self._moved = 0.0
        # Rows in lengths keep the normal equations well scaled.
        row = np.array([1.0, *(self._place / self._length)])
        self._normal = keep * self._normal + np.outer(row, row)
        self._right = keep * self._right + area * row
        self._squares = keep * self._squares + area * area
        if self._way < LEAST_WAYS * self._length:
            return None
        count = self._normal[0, 0]
        mean = self._normal[0, 1:] / count
        spread = self._normal[1:, 1:] / count - np.outer(mean, mean)
        low, high = np.linalg.eigvalsh(spread)
        if low < LEAST_SPREAD * high or high <= 0.0:
            return None
        fit = np.linalg.solve(self._normal, self._right)
        rest = max(self._squares - float(self._right @ fit), 0.0) / count
        slope = fit[1:]
        size = float(np.hypot(slope[0], slope[1]))
        least = LEAST_CHANGE * self._right[0] / count
        if size <= max(least, CLEAR * np.sqrt(rest / (count * low))):
            return None
        return slope / self._length

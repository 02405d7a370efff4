"""Slope of the imprint's area over the surface, by a plane fit along the path."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MIN_SPREAD = 1e-3
"""Minimum share of the path's variance across its direction. A straight path determines only one
of the two components. A path that weaves by 0.6 rad has 0.01."""
MIN_SIGNIFICANCE = 2.5
"""Minimum slope, in its own standard errors."""
MIN_CHANGE = 0.01
"""Minimum change of the area over one length, as a share of the area. The imprint of a flat face
changes less."""


class AreaSlope:
    """Least squares fit of the area over the position; older positions have less weight.

    Parameters
    ----------
    length
        Distance over which the weight of a position falls to a third, m.
    """

    def __init__(self, length: float) -> None:
        self._length = length
        self._position = np.zeros(2)
        self._moved = self._travel = 0.0
        self._normal = np.zeros((3, 3))
        self._right = np.zeros(3)
        self._squares = 0.0

    def move(self, motion: NDArray[np.float64]) -> None:
        """Add the motion since the last area, (2,), m."""
        self._position += motion
        distance = float(np.hypot(motion[0], motion[1]))
        self._moved += distance
        self._travel += distance

    def update(self, area: float) -> NDArray[np.float64] | None:
        """Add an area, m², and return its slope over x and y, (2,), m; None if not significant."""
        decay = np.exp(-self._moved / self._length)
        self._moved = 0.0
        # Positions in units of the length keep the normal equations well scaled.
        row = np.array([1.0, *(self._position / self._length)])
        self._normal = decay * self._normal + np.outer(row, row)
        self._right = decay * self._right + area * row
        self._squares = decay * self._squares + area * area
        if self._travel < self._length:
            return None
        count = self._normal[0, 0]
        mean = self._normal[0, 1:] / count
        spread = self._normal[1:, 1:] / count - np.outer(mean, mean)
        low, high = np.linalg.eigvalsh(spread)
        if low < MIN_SPREAD * high or high <= 0.0:
            return None
        fit = np.linalg.solve(self._normal, self._right)
        residual = max(self._squares - float(self._right @ fit), 0.0) / count
        slope = fit[1:]
        size = float(np.hypot(slope[0], slope[1]))
        min_size = MIN_CHANGE * self._right[0] / count
        if size <= max(min_size, MIN_SIGNIFICANCE * np.sqrt(residual / (count * low))):
            return None
        return slope / self._length

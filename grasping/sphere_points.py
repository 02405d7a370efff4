"""Points spread evenly over the unit sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def evenly_on_sphere(count: int) -> NDArray[np.float64]:
    """Return points on the unit sphere along a spiral of the golden angle, (count, 3)."""
    azimuth = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    z = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    radius = np.sqrt(1.0 - z**2)
    return np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), z])

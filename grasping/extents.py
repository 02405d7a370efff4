"""Extents of a solid that matter for a grasp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.perception import Superquadric, perpendicular_pair

DIRECTIONS = 90
"""Number of closing directions tried over half a turn, one every 2°."""
FINE_DIRECTIONS = 41
"""Number of directions tried around the best one, one every 0.1°."""
ROUND_SHARE = 0.04
"""Maximum relative difference of the widths of a round object."""


@dataclass(frozen=True)
class Extents:
    """Widths of a solid between two parallel planes."""

    height: float
    """Extent along up, m."""
    width: float
    """Minimum horizontal width, m."""
    length: float
    """Horizontal width perpendicular to it, m."""
    closing: NDArray[np.float64]
    """Unit direction of the smallest width, (3,)."""
    up: NDArray[np.float64]
    """Unit up direction, (3,)."""
    round: bool
    """Whether all horizontal widths are about equal."""


def measure_extents(solid: Superquadric, up: NDArray[np.float64]) -> Extents:
    """Measure the extents of a solid relative to an up direction (3,), by its support function."""
    up = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    side, other = perpendicular_pair(up)
    step = np.pi / DIRECTIONS
    angles = np.arange(DIRECTIONS) * step
    widths = _widths(solid, angles, side, other)
    near = angles[int(np.argmin(widths))]
    # The width of a box has a sharp minimum, so the coarse search misses it by up to 1°.
    fine = near + np.linspace(-step, step, FINE_DIRECTIONS)
    narrow = float(fine[int(np.argmin(_widths(solid, fine, side, other)))])
    closing = np.cos(narrow) * side + np.sin(narrow) * other
    across = np.cross(up, closing)
    return Extents(
        height=float(solid.support(up) + solid.support(-up)),
        width=float(solid.support(closing) + solid.support(-closing)),
        length=float(solid.support(across) + solid.support(-across)),
        closing=closing,
        up=up,
        round=bool(widths.max() - widths.min() < ROUND_SHARE * widths.max()),
    )


def _widths(
    solid: Superquadric,
    angles: NDArray[np.floating],
    side: NDArray[np.float64],
    other: NDArray[np.float64],
) -> NDArray[np.float64]:
    directions = np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * other
    return solid.support(directions) + solid.support(-directions)

"""The lengths of a solid that a hand cares about, relative to up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception import perpendicular_pair

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

DIRECTIONS = 90
"""Closing directions tried over half a turn: one every 2°."""
FINE = 41
"""Directions tried again around the best: one every 0.1°."""
ROUND = 0.04
"""Widths that differ by less than this share count as round."""


@dataclass(frozen=True)
class Extents:
    """Caliper widths of a solid."""

    height: float
    """Extent along up, m."""
    width: float
    """Smallest horizontal caliper width, m."""
    length: float
    """Horizontal caliper width across it, m."""
    closing: NDArray[np.float64]
    """Unit direction along which the smallest width is measured, (3,)."""
    up: NDArray[np.float64]
    """Unit up direction, (3,)."""
    round: bool
    """Whether every horizontal direction is about as wide: any closing direction will do."""


def measure(solid: Superquadric, up: NDArray[np.float64]) -> Extents:
    """Measure a solid by its support function (a caliper's two jaws are two support planes)."""
    up = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    side, other = perpendicular_pair(up)
    step = np.pi / DIRECTIONS
    angles = np.arange(DIRECTIONS) * step
    widths = _widths(solid, angles, side, other)
    near = angles[int(np.argmin(widths))]
    # A box's narrow side is a sharp minimum: between two steps it would be missed by a degree.
    fine = near + np.linspace(-step, step, FINE)
    narrow = float(fine[int(np.argmin(_widths(solid, fine, side, other)))])
    closing = np.cos(narrow) * side + np.sin(narrow) * other
    across = np.cross(up, closing)
    return Extents(
        height=float(solid.support(up) + solid.support(-up)),
        width=float(solid.support(closing) + solid.support(-closing)),
        length=float(solid.support(across) + solid.support(-across)),
        closing=closing,
        up=up,
        round=bool(widths.max() - widths.min() < ROUND * widths.max()),
    )


def _widths(
    solid: Superquadric,
    angles: NDArray[np.floating],
    side: NDArray[np.float64],
    other: NDArray[np.float64],
) -> NDArray[np.float64]:
    directions = np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * other
    return solid.support(directions) + solid.support(-directions)

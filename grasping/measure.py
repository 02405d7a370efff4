"""The lengths of a solid that a hand cares about, relative to up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.perpendicular import perpendicular_pair

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

DIRECTIONS = 90
"""Closing directions tried over half a turn: one every 2°."""
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
    angles = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    directions = np.cos(angles)[:, None] * side + np.sin(angles)[:, None] * other
    widths = solid.support(directions) + solid.support(-directions)
    narrow = int(np.argmin(widths))
    closing = directions[narrow]
    across = np.cross(up, closing)
    return Extents(
        height=float(solid.support(up) + solid.support(-up)),
        width=float(widths[narrow]),
        length=float(solid.support(across) + solid.support(-across)),
        closing=closing,
        up=up,
        round=bool(widths.max() - widths.min() < ROUND * widths.max()),
    )

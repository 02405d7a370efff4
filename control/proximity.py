"""The distances of the robot to near parts, with normals and derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Proximity:
    """The P pairs of parts nearer than a cut-off, in a fixed order of the pairs; all copies."""

    names: tuple[tuple[str, str], ...]
    """P pairs (part of the robot, obstacle or other part)."""
    distance: NDArray[np.float64]
    """Signed distance (P,), m: negative inside, by how far the parts must move to come apart."""
    normal: NDArray[np.float64]
    """Unit directions (P, 3), world: moving the robot's point there raises the distance."""
    on_robot: NDArray[np.float64]
    """Nearest points of the robot's parts (P, 3), m, world; the deepest ones inside."""
    on_other: NDArray[np.float64]
    """Nearest points of the other parts (P, 3), m, world."""
    rows: NDArray[np.float64]
    """Change of distance by joint motion (P, n), m/rad (m/m of a sliding joint)."""
    drift: NDArray[np.float64]
    """Change of distance by the obstacles' own motion (P,), m/s."""

"""The container of a scene: the floor, the walls and the rim of a bin, tote, box or tray."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from .result import SupportPlane


@dataclass(frozen=True)
class Wall:
    """One flat wall of a container. It is background, and an obstacle for the hand."""

    corners: NDArray[np.float64]
    """Corners (4, 3) of the inner face, m: two at the floor, then the two above them at the rim in
    opposite order."""
    thickness: float
    """Thickness of the wall at the rim, m."""
    seen: bool = True
    """Whether its rim was measured. Otherwise it continues the height of the other walls."""

    @property
    def outwards(self) -> NDArray[np.float64]:
        """Unit normal (3,) of the inner face, away from the inside."""
        along = self.corners[1] - self.corners[0]
        up = self.corners[3] + self.corners[2] - self.corners[0] - self.corners[1]
        normal = np.cross(along, up)
        return normal / np.linalg.norm(normal)


@dataclass(frozen=True)
class Container:
    """A bin, tote, box or tray. Its floor and walls are no objects."""

    floor: SupportPlane
    """The floor. If no part of it is visible, this plane lies below all readings inside."""
    walls: tuple[Wall, ...]
    """The walls, in order around the floor, counterclockwise from above."""
    rim: float
    """Height of the rim above the floor, m: the median of the walls."""
    floor_seen: bool = True
    """Whether a part of the floor is visible. A heap may hide it."""

    @property
    def outline(self) -> NDArray[np.float64]:
        """Corners (K, 3) of the floor, m, in order around it."""
        return np.array([wall.corners[0] for wall in self.walls])

    def moved(self, T_a_b: RigidTransform) -> Container:
        """Return the container in frame a, for a container in frame b."""
        walls = tuple(replace(wall, corners=T_a_b.apply(wall.corners)) for wall in self.walls)
        return replace(self, floor=self.floor.moved(T_a_b), walls=walls)

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
    def axes(self) -> NDArray[np.float64]:
        """Directions along the wall, outwards, and up its inner face as rows (3, 3)."""
        along = self.corners[1] - self.corners[0]
        along = along / np.linalg.norm(along)
        up = self.corners[3] + self.corners[2] - self.corners[0] - self.corners[1]
        outwards = np.cross(along, up)
        outwards /= np.linalg.norm(outwards)
        return np.array([along, outwards, np.cross(along, outwards)])

    def bounds(self) -> NDArray[np.float64]:
        """Return the least and greatest coordinates (2, 3) of the wall along its `axes`, m."""
        local = self.corners @ self.axes.T
        low, high = local.min(axis=0), local.max(axis=0)
        high[1] = low[1] + self.thickness
        return np.array([low, high])


@dataclass(frozen=True)
class Container:
    """A bin, tote, box or tray. Its floor and walls do not count as objects."""

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

    def on_walls(self, points: NDArray[np.float64], margin: float) -> NDArray[np.bool_]:
        """Return a mask (N,) of the points (N, 3) in or near the walls, within a margin, m."""
        found = np.zeros(len(points), bool)
        for wall in self.walls:
            local, (low, high) = points @ wall.axes.T, wall.bounds()
            found |= ((local >= low - margin) & (local <= high + margin)).all(axis=1)
        return found

    def moved(self, T_a_b: RigidTransform) -> Container:
        """Return the container in frame a, for a container in frame b."""
        walls = tuple(replace(wall, corners=T_a_b.apply(wall.corners)) for wall in self.walls)
        return replace(self, floor=self.floor.moved(T_a_b), walls=walls)

"""Where objects are put: a tray with a floor and four walls, filled place by place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import Box, Obstacle
from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Tray:
    """An open box whose sides lie along the world's axes.

    Raises
    ------
    InputError
        If an extent is not positive, or there is no place.
    """

    centre: NDArray[np.float64]
    """Middle of the floor's upper face, (3,), world, m."""
    size: tuple[float, float]
    """Inner extent along x and y, m."""
    wall_height: float
    """Height of the walls over the floor, m."""
    wall: float = 0.006
    """Thickness of walls and floor, m."""
    places: tuple[int, int] = (2, 3)
    """Objects side by side along x and y; then a second layer begins."""

    def __post_init__(self) -> None:
        if min(*self.size, self.wall_height, self.wall) <= 0:
            raise InputError(
                f"a tray's extents must be > 0 m, got {self.size}, {self.wall_height}, {self.wall}"
            )
        if min(self.places) < 1:
            raise InputError(f"a tray needs one place at least, got {self.places}")

    def place(self, number: int) -> NDArray[np.float64]:
        """Give the point of the floor where the object with this number goes, (3,), world, m."""
        rows, columns = self.places
        row, column = divmod(number % (rows * columns), columns)
        share = np.array([(row + 0.5) / rows - 0.5, (column + 0.5) / columns - 0.5])
        return self.centre + np.append(share * self.size, 0.0)

    def layer(self, number: int) -> int:
        """Tell on which layer the object with this number goes, 0 being the floor."""
        rows, columns = self.places
        return number // (rows * columns)

    def holds(self, point: NDArray[np.float64]) -> bool:
        """Tell whether a point (3,), world, lies over the tray's floor."""
        return bool((np.abs(point[:2] - self.centre[:2]) <= 0.5 * np.asarray(self.size)).all())

    def distance(self, point: NDArray[np.float64]) -> float:
        """Give how far a point (3,), world, lies outside the tray's floor in plan, m; 0 over it."""
        beyond = np.abs(point[:2] - self.centre[:2]) - 0.5 * np.asarray(self.size)
        return float(np.linalg.norm(np.maximum(beyond, 0.0)))

    def filled(self, height: float) -> Obstacle:
        """Give the space up to a height over the floor, m, as one block, walls included."""
        half = np.append(0.5 * np.asarray(self.size) + self.wall, 0.5 * (height + self.wall))
        middle = self.centre + np.array([0.0, 0.0, 0.5 * (height - self.wall)])
        return Obstacle("tray", Box(half), RigidTransform.from_translation(middle))

    def obstacles(self) -> tuple[Obstacle, ...]:
        """Give floor and walls for the arm to keep off."""
        (x, y), t, h = 0.5 * np.asarray(self.size), self.wall, self.wall_height
        parts = {
            "floor": ((0.0, 0.0, -0.5 * t), (x + t, y + t, 0.5 * t)),
            "-x": ((-x - 0.5 * t, 0.0, 0.5 * h), (0.5 * t, y + t, 0.5 * h)),
            "+x": ((x + 0.5 * t, 0.0, 0.5 * h), (0.5 * t, y + t, 0.5 * h)),
            "-y": ((0.0, -y - 0.5 * t, 0.5 * h), (x + t, 0.5 * t, 0.5 * h)),
            "+y": ((0.0, y + 0.5 * t, 0.5 * h), (x + t, 0.5 * t, 0.5 * h)),
        }
        return tuple(
            Obstacle(
                f"tray {name}",
                Box(np.asarray(half)),
                RigidTransform.from_translation(self.centre + np.asarray(at)),
            )
            for name, (at, half) in parts.items()
        )

"""The tray that objects are put into: a floor and four walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.control import Box, Obstacle
from eyehand.errors import InputError


@dataclass(frozen=True)
class Tray:
    """An open box with sides parallel to the world's x and y axes.

    Raises
    ------
    InputError
        If an extent is not positive, or the centre is not finite.
    """

    centre: NDArray[np.float64]
    """Centre of the floor's upper face, (3,), world, m."""
    size: tuple[float, float]
    """Inner extent along x and y, m."""
    wall_height: float
    """Height of the walls above the floor, m."""
    wall_thickness: float = 0.006
    """Thickness of walls and floor, m."""

    def __post_init__(self) -> None:
        sizes = (*self.size, self.wall_height, self.wall_thickness)
        if not all(0.0 < size < np.inf for size in sizes):
            raise InputError(
                "a tray's size, wall_height and wall_thickness must be > 0 m, got "
                f"{self.size}, {self.wall_height}, {self.wall_thickness}"
            )
        if np.shape(self.centre) != (3,) or not np.all(np.isfinite(self.centre)):
            raise InputError(f"a tray's centre must be 3 finite numbers, m, got {self.centre}")

    def contains(self, point: NDArray[np.float64], margin: float = 0.0) -> bool:
        """Return whether a point (3,), world, m, is above the tray's floor in plan view.

        It must be at least a margin, m, inside the walls.
        """
        half = 0.5 * np.asarray(self.size) - margin
        return bool((np.abs(point[:2] - self.centre[:2]) <= half).all())

    def encloses(
        self, points: NDArray[np.float64], margin: float, *, content: bool = False
    ) -> NDArray[np.bool_]:
        """Return a mask (N,) of the points (N, 3), world, m, in the tray or its walls.

        The walls are grown by a margin, m. Points above the walls count only with ``content``.
        """
        beyond = np.abs(points[:, :2] - self.centre[:2]) - 0.5 * np.asarray(self.size)
        low = content | (points[:, 2] <= self.centre[2] + self.wall_height + margin)
        inside: NDArray[np.bool_] = low & (beyond <= self.wall_thickness + margin).all(axis=1)
        return inside

    def distance(self, point: NDArray[np.float64]) -> float:
        """Return the horizontal distance of a point (3,), world, from the floor, m; 0 above it."""
        beyond = np.abs(point[:2] - self.centre[:2]) - 0.5 * np.asarray(self.size)
        return float(np.linalg.norm(np.maximum(beyond, 0.0)))

    def as_box(self, height: float) -> Obstacle:
        """Return one box that encloses the tray up to a height above the floor, m."""
        half = np.append(
            0.5 * np.asarray(self.size) + self.wall_thickness, 0.5 * (height + self.wall_thickness)
        )
        middle = self.centre + np.array([0.0, 0.0, 0.5 * (height - self.wall_thickness)])
        return Obstacle("tray", Box(half), RigidTransform.from_translation(middle))

    def obstacles(self) -> tuple[Obstacle, ...]:
        """Return the floor and the walls as obstacles."""
        (x, y), t, h = 0.5 * np.asarray(self.size), self.wall_thickness, self.wall_height
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

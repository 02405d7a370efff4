"""Vessels: a solid with an opening, a rim and a cavity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from .shape import Superquadric

UNKNOWN_WALL = 0.003
"""Wall with which a vessel is drawn if its wall is unknown, m: that of common cups and bowls."""

EDGE_SHARE = 0.05
"""Share of the height below the top of the outer solid where its edge is round."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Rim:
    """The edge of an opening, a circle or an ellipse: the outer line of its highest points."""

    centre: NDArray[np.float64]
    """(3,), m, in the frame of the solid."""
    semi_axes: NDArray[np.float64]
    """(2,) m, the larger one first."""
    directions: NDArray[np.float64]
    """(2, 3) unit directions of the semi-axes, at right angles."""

    @property
    def opening(self) -> NDArray[np.float64]:
        """Return the unit direction (3,) out of the vessel, perpendicular to the rim."""
        return np.cross(self.directions[0], self.directions[1])

    def scale(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the scale (…,) of the rim about its middle that touches points (…, 3).

        Heights above or below the plane of the rim do not count.
        """
        flat = (np.asarray(points, dtype=np.float64) - self.centre) @ self.directions.T
        return np.linalg.norm(flat / self.semi_axes, axis=-1)

    def points(self, count: int = 64) -> NDArray[np.float64]:
        """Return points (count, 3), m, around the rim, counter-clockwise seen from outside."""
        angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
        flat = np.column_stack([np.cos(angle), np.sin(angle)]) * self.semi_axes
        return self.centre + flat @ self.directions


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class Vessel:
    """A bowl, mug or cup: an outer solid with a cavity that is open at its rim.

    The cavity keeps the distance `wall` from the outer surface, floor included, up to the plane of
    the rim. What lies above that plane does not belong to the vessel. A ring is a vessel without a
    floor.

    Raises
    ------
    InputError
        If the wall is not positive and finite.
    """

    outer: Superquadric
    """The solid without its cavity, closed at the rim."""
    rim: Rim
    """The edge of the opening, in the same frame."""
    wall: float | None = None
    """Thickness of the wall, m; None if the view does not resolve it."""
    through: bool = False
    """Whether the opening goes through: a ring, such as a roll of tape, without a floor."""

    def __post_init__(self) -> None:
        if self.wall is not None and not 0.0 < self.wall < float("inf"):
            raise InputError(f"the wall of a vessel must be finite and > 0 m, got {self.wall}")

    @property
    def opening(self) -> NDArray[np.float64]:
        """Unit direction (3,) out of the vessel."""
        return self.rim.opening

    @property
    def drawn_wall(self) -> float:
        """The wall, m, or UNKNOWN_WALL where it is not resolved."""
        return UNKNOWN_WALL if self.wall is None else self.wall

    def heights(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the heights (…,) of points (…, 3) above the plane of the rim, m."""
        return (np.asarray(points, dtype=np.float64) - self.rim.centre) @ self.opening

    @property
    def top_height(self) -> float:
        """Height of the upper end of the vessel above the plane of the rim, m, 0 or below."""
        top = float(self.outer.support(self.opening) - self.rim.centre @ self.opening)
        return min(top, 0.0)

    @property
    def edge_height(self) -> float:
        """Height above the plane of the rim, m, at which the rounding of the outer edge begins."""
        extent = float(self.outer.support(self.opening) + self.outer.support(-self.opening))
        return self.top_height - max(EDGE_SHARE * extent, self.drawn_wall)

    @property
    def foot_height(self) -> float:
        """Height of the lower end of the outer solid above the plane of the rim, m: negative."""
        return -float(self.outer.support(-self.opening) + self.rim.centre @ self.opening)

    def _between_edges(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (…, 3) moved along the opening to where the walls are straight.

        The outer solid is closed. Its walls continue straight from its edges.
        """
        heights = self.heights(points)
        edge = self.edge_height
        level = np.minimum(heights, edge)
        if self.through:
            lower = self.foot_height + (self.top_height - edge)
            level = np.maximum(level, min(lower, edge))
        return points - (heights - level)[..., None] * self.opening

    def cavity_distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the first-order distance (…,) of points (…, 3) from the walls of the cavity, m.

        It is negative in the cavity. The cavity continues above the rim, and below a ring.
        """
        points = np.asarray(points, dtype=np.float64)
        return self.outer.distance(self._between_edges(points)) + self.drawn_wall

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the first-order distance (…,) of points (…, 3) from the surface, m.

        It is negative in the wall and the floor. It is meaningful near the surface only.
        """
        points = np.asarray(points, dtype=np.float64)
        outside = np.maximum(self.outer.distance(points), self.heights(points))
        return np.maximum(outside, -self.cavity_distance(points))

    def normals(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return unit normals (…, 3) of the nearer surface, out of the material, at points (…, 3).

        In the plane of the rim they point out of the opening.
        """
        points = np.asarray(points, dtype=np.float64)
        height, inner = self.heights(points), -self.cavity_distance(points)
        between = self._between_edges(points)
        outwards = self.outer.normals(between)
        outer = self.outer.distance(between)
        sides = np.where((np.abs(inner) < np.abs(outer))[..., None], -outwards, outwards)
        at_rim = np.abs(height) < 0.5 * self.drawn_wall
        return np.where(at_rim[..., None], self.opening, sides)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points (…, 3) lie in the wall or the floor, (…,) bool."""
        return self.distance(points) <= 0.0

    def support(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Return the largest ``d·x`` over the outer solid for directions d (…, 3), (…,), m."""
        return self.outer.support(directions)

    @property
    def volume(self) -> float:
        """Volume of the wall and the floor, m³, with UNKNOWN_WALL where the wall is unknown."""
        from .vessel_mesh import vessel_mesh

        vertices, faces = vessel_mesh(self)
        first, second, third = np.moveaxis((vertices - self.rim.centre)[faces], 1, 0)
        return float(np.sum(first * np.cross(second, third)) / 6.0)

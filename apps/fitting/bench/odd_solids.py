"""Convex solids that no superquadric equals: cup, capsule, hexagonal prism, half ball, wedge."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.data_synth.scenes import hull_mesh

AROUND = 180
"""Mesh points around a round solid. At 80 mm radius the error is 0.012 mm."""
ARC = 46
"""Mesh points from the equator of a ball to its pole."""
CUP_RADII, CUP_FLARE, CUP_HALF_HEIGHTS = (0.02, 0.04), (1.1, 1.5), (0.03, 0.06)
"""Ranges of the foot radius of a cup, m, the ratio of rim to foot, and half its height, m."""
CAPSULE_RADII, CAPSULE_HALF_LENGTHS = (0.015, 0.035), (0.015, 0.05)
HEXAGON_RADII, HEXAGON_HALF_HEIGHTS = (0.02, 0.05), (0.015, 0.08)
HALF_BALL_RADII = (0.03, 0.08)
WEDGE_HALF_LENGTHS, WEDGE_HALF_WIDTHS, WEDGE_HALF_HEIGHTS = (
    (0.03, 0.08),
    (0.015, 0.06),
    (0.015, 0.05),
)


class OddShape(Protocol):
    """A convex shape with the middle of its bounds at the origin."""

    def inside(self, local: NDArray[np.float64], /) -> NDArray[np.bool_]:
        """Return whether points (…, 3), m, lie inside or on the surface, (…,), exactly."""
        ...

    def corners(self) -> NDArray[np.float64]:
        """Return points (V, 3), m, whose convex hull is the shape or inscribed in it."""
        ...


@dataclass(frozen=True)
class Frustum:
    """An upright truncated cone: a solid cup."""

    bottom: float
    """Radius at the foot, m."""
    top: float
    """Radius at the rim, m."""
    half_height: float
    """m."""

    def inside(self, local: NDArray[np.float64]) -> NDArray[np.bool_]:
        """See OddShape."""
        x, y, z = np.moveaxis(local, -1, 0)
        share = (z / self.half_height + 1) / 2
        radius = self.bottom + share * (self.top - self.bottom)
        return (np.abs(z) <= self.half_height) & (np.hypot(x, y) <= radius)

    def corners(self) -> NDArray[np.float64]:
        """See OddShape."""
        return _revolved([(self.bottom, -self.half_height), (self.top, self.half_height)])


@dataclass(frozen=True)
class Capsule:
    """A cylinder along x with half a ball at each end."""

    radius: float
    """m."""
    half_length: float
    """Half length of the straight part, m."""

    def inside(self, local: NDArray[np.float64]) -> NDArray[np.bool_]:
        """See OddShape."""
        x, y, z = np.moveaxis(local, -1, 0)
        past = np.maximum(np.abs(x) - self.half_length, 0.0)
        return past**2 + y**2 + z**2 <= self.radius**2

    def corners(self) -> NDArray[np.float64]:
        """See OddShape."""
        turn = np.linspace(0.0, np.pi / 2, ARC)
        arc = self.radius * np.column_stack([np.cos(turn), np.sin(turn)])
        upper = np.add(arc, [0.0, self.half_length])
        # The axis of revolution is z. Rolling the coordinates moves it to x.
        return np.roll(_revolved([*upper, *(upper * [1, -1])]), 1, axis=1)


@dataclass(frozen=True)
class Prism:
    """A convex polygon extruded along one axis."""

    outline: tuple[tuple[float, float], ...]
    """Corners (p, q), counter-clockwise, m."""
    half_height: float
    """m."""
    upright: bool
    """Whether (p, q) are (x, y), extruded along z; else (x, z), extruded along y."""

    def inside(self, local: NDArray[np.float64]) -> NDArray[np.bool_]:
        """See OddShape."""
        p, q, along = (0, 1, 2) if self.upright else (0, 2, 1)
        flat, height = local[..., [p, q]], local[..., along]
        corner = np.array(self.outline)
        edge = np.roll(corner, -1, axis=0) - corner
        outward = np.column_stack([edge[:, 1], -edge[:, 0]])
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        reach = np.einsum("ij,ij->i", outward, corner)
        return np.all(flat @ outward.T <= reach, axis=-1) & (np.abs(height) <= self.half_height)

    def corners(self) -> NDArray[np.float64]:
        """See OddShape."""
        corner = np.array(self.outline)
        axis = 2 if self.upright else 1
        heights = (-self.half_height, self.half_height)
        return np.vstack([np.insert(corner, axis, height, axis=1) for height in heights])


@dataclass(frozen=True)
class HalfBall:
    """The upper half of a ball."""

    radius: float
    """m."""

    def inside(self, local: NDArray[np.float64]) -> NDArray[np.bool_]:
        """See OddShape."""
        z = local[..., 2] + self.radius / 2
        return (z >= 0) & (local[..., 0] ** 2 + local[..., 1] ** 2 + z**2 <= self.radius**2)

    def corners(self) -> NDArray[np.float64]:
        """See OddShape."""
        turn = np.linspace(0.0, np.pi / 2, ARC)
        arc = self.radius * np.column_stack([np.cos(turn), np.sin(turn) - 0.5])
        return _revolved([*arc])


@dataclass(frozen=True)
class PosedSolid:
    """A shape at its pose: a `TrueSolid`."""

    shape: OddShape
    """The shape."""
    pose: RigidTransform
    """Maps shape coordinates to the cloud's frame."""

    @property
    def centre(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        return np.asarray(self.pose.translation)

    @property
    def rotation(self) -> NDArray[np.float64]:
        """See TrueSolid."""
        return np.asarray(self.pose.rotation.as_matrix())

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """See TrueSolid."""
        local = (np.asarray(points, dtype=np.float64) - self.centre) @ self.rotation
        return self.shape.inside(local)

    def support(self, directions: ArrayLike) -> NDArray[np.float64]:
        """See TrueSolid; computed from the mesh."""
        return (np.asarray(directions, dtype=np.float64) @ self._mesh[0].T).max(axis=-1)

    def mesh(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return vertices (V, 3), m, and faces (T, 3), counter-clockwise from outside."""
        return self._mesh

    @cached_property
    def _mesh(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        vertices, faces = hull_mesh(self.shape.corners())
        return vertices @ self.rotation.T + self.centre, faces


def draw_cup(rng: np.random.Generator) -> OddShape:
    """Draw a cup, wider at its rim."""
    foot = rng.uniform(*CUP_RADII)
    return Frustum(foot, foot * rng.uniform(*CUP_FLARE), rng.uniform(*CUP_HALF_HEIGHTS))


def draw_capsule(rng: np.random.Generator) -> OddShape:
    """Draw a lying capsule."""
    return Capsule(rng.uniform(*CAPSULE_RADII), rng.uniform(*CAPSULE_HALF_LENGTHS))


def draw_hexagonal_prism(rng: np.random.Generator) -> OddShape:
    """Draw an upright prism over a regular hexagon."""
    radius, turn = rng.uniform(*HEXAGON_RADII), np.arange(6) * np.pi / 3
    outline = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return Prism(_pairs(outline), rng.uniform(*HEXAGON_HALF_HEIGHTS), upright=True)


def draw_half_ball(rng: np.random.Generator) -> OddShape:
    """Draw half a ball on its flat side."""
    return HalfBall(rng.uniform(*HALF_BALL_RADII))


def draw_wedge(rng: np.random.Generator) -> OddShape:
    """Draw a ramp: a prism over a right triangle, on one of its legs."""
    length, height = rng.uniform(*WEDGE_HALF_LENGTHS), rng.uniform(*WEDGE_HALF_HEIGHTS)
    outline = np.array([[-length, -height], [length, -height], [-length, height]])
    return Prism(_pairs(outline), rng.uniform(*WEDGE_HALF_WIDTHS), upright=False)


DRAWERS = {
    "cup": draw_cup,
    "capsule": draw_capsule,
    "hexagonal prism": draw_hexagonal_prism,
    "half ball": draw_half_ball,
    "wedge": draw_wedge,
}
"""Name → function that draws the shape as it stands on a table."""


def _revolved(profile: list) -> NDArray[np.float64]:
    """Revolve the points (radius, z) of a profile about z, (len(profile) * AROUND, 3)."""
    radius, z = np.array(profile, dtype=np.float64).T[..., None]
    angle = np.linspace(0.0, 2 * np.pi, AROUND, endpoint=False)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return np.stack([x, y, np.broadcast_to(z, x.shape)], axis=-1).reshape(-1, 3)


def _pairs(points: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    return tuple((float(p), float(q)) for p, q in points)

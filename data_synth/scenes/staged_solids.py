"""Solids for staged scenes, full and hollow. Each stands on z = 0 at the origin, z up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric

from .convex_mesh import convex_mesh
from .staged_mesh import tapered_mesh, tube_mesh, turned_mesh

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]


ARC_POINTS = 24
"""Points on a quarter circle of a profile: a radius of 70 mm is exact to 0.04 mm."""
FOOT_SHARE = 0.4
"""Radius of the flat foot of a bowl over the radius of its rim."""
HANDLE_SPAN = 0.64
"""Height of a mug's handle over the height of the mug."""
HANDLE_REACH = 0.7
"""Distance by which the handle stands out, over the height of the handle."""


@dataclass(frozen=True)
class Turned:
    """A solid of revolution about the z-axis."""

    profile: tuple[tuple[float, float], ...]
    """Radius and z, m, counter-clockwise (see :func:`turned_mesh`)."""

    def mesh(self) -> Mesh:
        """Vertices (V, 3), m, and faces (T, 3)."""
        return turned_mesh(self.profile)


@dataclass(frozen=True)
class Tapered:
    """A box with different extents at top and bottom."""

    bottom: tuple[float, float]
    """Extents along x and y at z = 0, m."""
    top: tuple[float, float]
    """Extents along x and y at the top, m."""
    height: float
    """Extent along z, m."""

    def mesh(self) -> Mesh:
        """Vertices (V, 3), m, and faces (T, 3)."""
        return tapered_mesh(self.bottom, self.top, self.height)


@dataclass(frozen=True)
class Tube:
    """A round bar whose centre line lies in the xz-plane."""

    path: tuple[tuple[float, float], ...]
    """Points (x, z) of the centre line, m."""
    radius: float
    """Radius of the bar, m."""

    def mesh(self) -> Mesh:
        """Vertices (V, 3), m, and faces (T, 3)."""
        return tube_mesh(self.path, self.radius)


@dataclass(frozen=True)
class Rounded:
    """A convex superquadric whose lowest point is the origin."""

    size: tuple[float, float, float]
    """Extents, m."""
    exponents: tuple[float, float]
    """ε1 and ε2."""

    def mesh(self) -> Mesh:
        """Vertices (V, 3), m, and faces (T, 3)."""
        half = np.array(self.size) / 2
        shape = Superquadric(half, self.exponents, RigidTransform.identity())
        vertices, faces = convex_mesh(shape)
        return vertices + np.array([0.0, 0.0, half[2]]), faces


@dataclass(frozen=True)
class Ball:
    """A sphere whose lowest point is the origin: the only part that is rendered without a mesh."""

    radius: float
    """Radius, m."""


Part = Turned | Tapered | Tube | Rounded | Ball


@dataclass(frozen=True)
class StagedSolid:
    """A rigid solid of one or more parts, which may overlap inside."""

    parts: tuple[Part, ...]
    """Parts in the solid's frame: the centre of its foot at the origin, z up."""
    height: float
    """Height of its highest point, m."""


def box(x: float, y: float, z: float) -> StagedSolid:
    """Return a box with extents x, y, z, m."""
    return tapered_box((x, y), (x, y), z)


def tapered_box(
    bottom: tuple[float, float], top: tuple[float, float], height: float
) -> StagedSolid:
    """Return a box with extents (x, y) at its bottom and at its top, m."""
    _check_lengths("extents of a box", (*bottom, *top, height))
    return StagedSolid((Tapered(bottom, top, height),), height)


def cylinder(radius: float, height: float) -> StagedSolid:
    """Return an upright cylinder; lengths in m."""
    return cone(radius, radius, height)


def cone(bottom_radius: float, top_radius: float, height: float) -> StagedSolid:
    """Return an upright frustum of a cone; lengths in m."""
    _check_lengths("radii and height of a cone", (bottom_radius, top_radius, height))
    return StagedSolid((Turned(((bottom_radius, 0.0), (top_radius, height))),), height)


def ball(radius: float) -> StagedSolid:
    """Return a sphere; radius in m."""
    _check_lengths("radius of a ball", (radius,))
    return StagedSolid((Ball(radius),), 2 * radius)


def superquadric(size: tuple[float, float, float], exponents: tuple[float, float]) -> StagedSolid:
    """Return a convex superquadric with extents (x, y, z), m, and exponents (ε1, ε2)."""
    _check_lengths("extents of a superquadric", size)
    return StagedSolid((Rounded(size, exponents),), size[2])


def rod(radius: float, length: float) -> StagedSolid:
    """Return a cylinder that lies along x; lengths in m."""
    _check_lengths("radius and length of a rod", (radius, length))
    path = ((-length / 2, radius), (length / 2, radius))
    return StagedSolid((Tube(path, radius),), 2 * radius)


def bowl(radius: float, depth: float, wall: float = 0.004) -> StagedSolid:
    """Return a hollow half ellipsoid, open at the top, on a small flat foot.

    Parameters
    ----------
    radius
        Outer radius of the rim, m.
    depth
        Distance from the rim down to the lowest point of the outside, m.
    wall
        Thickness of the wall, m.
    """
    _check_hollow("bowl", (radius, depth), wall)
    angle = np.linspace(0.0, np.pi / 2, ARC_POINTS)
    sine, cosine = np.sin(angle), np.cos(angle)
    above_foot = sine > FOOT_SHARE
    outside = np.column_stack([radius * sine, depth * (1 - cosine)])[above_foot]
    inside = np.column_stack([(radius - wall) * sine, depth - (depth - wall) * cosine])
    foot = (FOOT_SHARE * radius, 0.0)
    return StagedSolid((Turned((foot, *_pairs(outside), *_pairs(inside[::-1]))),), depth)


def cup(bottom_radius: float, top_radius: float, height: float, wall: float = 0.004) -> StagedSolid:
    """Return a hollow frustum of a cone, closed below and open at the top, such as a beaker.

    Parameters
    ----------
    bottom_radius, top_radius
        Outer radii, m.
    height
        Distance from the foot to the rim, m.
    wall
        Thickness of wall and floor, m.
    """
    _check_hollow("cup", (bottom_radius, top_radius, height), wall)
    profile = (
        (bottom_radius, 0.0),
        (top_radius, height),
        (top_radius - wall, height),
        (bottom_radius - wall, wall),
    )
    return StagedSolid((Turned(profile),), height)


def mug(
    radius: float, height: float, wall: float = 0.004, handle_radius: float = 0.006
) -> StagedSolid:
    """Return a cup with a handle on its +x side.

    Parameters
    ----------
    radius, height, wall
        Outer radius, height and wall thickness of the cup, m.
    handle_radius
        Radius of the handle's round bar, m.
    """
    _check_lengths("thickness of a mug's handle", (handle_radius,))
    vessel = cup(radius, radius, height, wall)
    # Half an ellipse whose ends lie in the middle of the wall.
    half = HANDLE_SPAN * height / 2
    turn = np.linspace(-np.pi / 2, np.pi / 2, 2 * ARC_POINTS)
    reach = 2 * HANDLE_REACH * half
    path = np.column_stack(
        [radius - wall / 2 + reach * np.cos(turn), height / 2 + half * np.sin(turn)]
    )
    return StagedSolid((*vessel.parts, Tube(_pairs(path), handle_radius)), height)


def _pairs(points: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    return tuple((float(first), float(second)) for first, second in points)


def _check_lengths(what: str, lengths: Sequence[float]) -> None:
    if not all(0 < length < np.inf for length in lengths):
        raise InputError(f"{what} must be > 0 m and finite, got {', '.join(map(str, lengths))}")


def _check_hollow(what: str, extents: tuple[float, ...], wall: float) -> None:
    _check_lengths(f"extents and wall of a {what}", (*extents, wall))
    if wall >= min(extents):
        raise InputError(f"wall of a {what} must be thinner than {min(extents)} m, got {wall} m")

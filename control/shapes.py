"""Convex shapes of obstacles and held objects, and the obstacle with its name and pose."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from .array_checks import checked_array, read_only

MIN_SIZE_M = 1e-6
"""Minimum size of a shape, m. A smaller one is probably a mistake of units."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box. Its frame is at the centre.

    Raises
    ------
    InputError
        If a half extent is not finite or is below MIN_SIZE_M.
    """

    half_extents: NDArray[np.float64]
    """Half the edge lengths along x, y and z (3,), m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "half_extents", _sizes(self.half_extents, "box: half_extents"))


@dataclass(frozen=True)
class Sphere:
    """A sphere. Its frame is at the centre.

    Raises
    ------
    InputError
        If the radius is not finite or is below MIN_SIZE_M.
    """

    radius: float
    """Radius, m."""

    def __post_init__(self) -> None:
        _check_size(self.radius, "sphere: radius")


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid. Its frame is at the centre.

    Raises
    ------
    InputError
        If a semi-axis is not finite or is below MIN_SIZE_M.
    """

    semi_axes: NDArray[np.float64]
    """Semi-axes along x, y and z (3,), m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "semi_axes", _sizes(self.semi_axes, "ellipsoid: semi_axes"))


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z. Its frame is at the centre.

    Raises
    ------
    InputError
        If a size is not finite or is below MIN_SIZE_M.
    """

    radius: float
    """Radius, m."""
    half_length: float
    """Half the length, m."""

    def __post_init__(self) -> None:
        _check_size(self.radius, "cylinder: radius")
        _check_size(self.half_length, "cylinder: half_length")


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with a hemisphere on each end. Its frame is at the centre.

    Raises
    ------
    InputError
        If a size is not finite or is below MIN_SIZE_M.
    """

    radius: float
    """Radius, m."""
    half_length: float
    """Half the length of the cylindrical part, m."""

    def __post_init__(self) -> None:
        _check_size(self.radius, "capsule: radius")
        _check_size(self.half_length, "capsule: half_length")


@dataclass(frozen=True, eq=False)
class ConvexMesh:
    """The convex hull of a set of points.

    Raises
    ------
    InputError
        If the points are not finite numbers (V, 3) with V >= 4, or enclose no volume.
    """

    vertices: NDArray[np.float64]
    """Points (V, 3), m, V >= 4. Only the vertices of the hull are kept."""

    def __post_init__(self) -> None:
        vertices = checked_array("convex mesh: vertices", self.vertices, ("V", 3))
        if len(vertices) < 4:
            raise InputError(
                f"convex mesh: vertices must be (V, 3) with V >= 4, got shape {vertices.shape}"
            )
        if np.ptp(vertices, axis=0).max() < MIN_SIZE_M:
            raise InputError(f"convex mesh: all vertices lie within {MIN_SIZE_M} m")
        try:
            hull = ConvexHull(vertices)
        except QhullError:
            raise InputError(
                f"convex mesh: the {len(vertices)} vertices lie in one plane; use a thin Box"
            ) from None
        object.__setattr__(self, "vertices", read_only(vertices[hull.vertices]))


Shape = Box | Sphere | Ellipsoid | Cylinder | Capsule | ConvexMesh
"""A convex shape."""
SHAPE_NAMES = ("Box", "Sphere", "Ellipsoid", "Cylinder", "Capsule", "ConvexMesh")
"""Names of the shapes for error messages."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """An object in the world that the robot must not touch.

    Raises
    ------
    InputError
        If the name is empty, the shape is of an unknown type, or the pose is not finite.
    """

    name: str
    """Name for :meth:`CollisionWorld.move` and :meth:`CollisionWorld.remove`."""
    shape: Shape
    """Shape of the obstacle, in its own frame."""
    pose: RigidTransform
    """Pose of the obstacle in the world (T_world_obstacle)."""

    def __post_init__(self) -> None:
        check_body("obstacle", self.name, self.shape, self.pose)


def check_body(kind: str, name: str, shape: Shape, pose: RigidTransform) -> None:
    """Check name, shape and pose of an obstacle or a held object; ``kind`` is for the message.

    Raises
    ------
    InputError
        If the name is empty, the shape is of an unknown type, or the pose is not finite.
    """
    if not isinstance(name, str) or not name:
        raise InputError(f"{kind}: the name must be a text that is not empty, got {name!r}")
    if not isinstance(shape, Shape):
        raise InputError(
            f"{name}: the shape must be one of {', '.join(SHAPE_NAMES)}, got {shape!r}"
        )
    check_pose(pose, name)


def check_pose(pose: RigidTransform, name: str) -> None:
    """Raise an :class:`InputError` if a value is not one finite pose; ``name`` is its owner."""
    if not isinstance(pose, RigidTransform) or not pose.single:
        raise InputError(f"{name}: the pose must be one RigidTransform, got {type(pose).__name__}")
    if not np.all(np.isfinite(pose.as_matrix())):
        raise InputError(f"{name}: the pose must be finite, got {pose.as_matrix().tolist()}")


def checked_obstacles(obstacles: Iterable[Obstacle]) -> tuple[Obstacle, ...]:
    """Return obstacles as a tuple; raise an :class:`InputError` if one is not an obstacle."""
    given = tuple(obstacles) if isinstance(obstacles, Iterable) else (obstacles,)
    for one in given:
        if not isinstance(one, Obstacle) or not isinstance(obstacles, Iterable):
            raise InputError(
                f"obstacles must be a list of Obstacle (name, shape, pose), got {one!r}"
            )
    return given


def _sizes(values: ArrayLike, name: str) -> NDArray[np.float64]:
    sizes = checked_array(name, values, (3,))
    for size in sizes:
        _check_size(float(size), name)
    return read_only(sizes)


def _check_size(value: float, name: str) -> None:
    try:
        fits = not isinstance(value, str) and MIN_SIZE_M <= float(value) < float("inf")
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise InputError(f"{name} must be finite and >= {MIN_SIZE_M} m, got {value}")

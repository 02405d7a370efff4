"""Plain convex shapes of obstacles and held objects, and an obstacle with its name and pose."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

SMALLEST_SIZE_M = 1e-6
"""Sizes below this are taken for zero: a micrometre is no obstacle, more likely a slip of units."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box about its centre.

    Raises
    ------
    InputError
        If a half extent is not a finite number above zero.
    """

    half_extents: NDArray[np.float64]
    """Half the edge lengths along x, y and z (3,), m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "half_extents", _sizes(self.half_extents, "box: half_extents"))


@dataclass(frozen=True)
class Sphere:
    """A sphere about its centre.

    Raises
    ------
    InputError
        If the radius is not a finite number above zero.
    """

    radius: float
    """Radius, m."""

    def __post_init__(self) -> None:
        _check_size(self.radius, "sphere: radius")


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """An ellipsoid about its centre.

    Raises
    ------
    InputError
        If a semi-axis is not a finite number above zero.
    """

    semi_axes: NDArray[np.float64]
    """Semi-axes along x, y and z (3,), m."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "semi_axes", _sizes(self.semi_axes, "ellipsoid: semi_axes"))


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z about its centre.

    Raises
    ------
    InputError
        If a size is not a finite number above zero.
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
    """A cylinder along z with a hemisphere on either end.

    Raises
    ------
    InputError
        If a size is not a finite number above zero.
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
    """The convex hull of points.

    Raises
    ------
    InputError
        If the points are not (V, 3) finite numbers, or enclose no volume.
    """

    vertices: NDArray[np.float64]
    """Points (V, 3), m, V >= 4; those inside the hull are dropped."""

    def __post_init__(self) -> None:
        vertices = _numbers(self.vertices, "convex mesh: vertices")
        if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4:
            raise InputError(
                f"convex mesh: vertices must be (V, 3) with V >= 4, got shape {vertices.shape}"
            )
        extent = np.ptp(vertices, axis=0)
        if float(extent.max()) < SMALLEST_SIZE_M:
            raise InputError(f"convex mesh: all vertices lie within {SMALLEST_SIZE_M} m")
        try:
            hull = ConvexHull(vertices)
        except QhullError:
            raise InputError(
                f"convex mesh: the {len(vertices)} vertices lie in one plane; use a thin Box"
            ) from None
        object.__setattr__(self, "vertices", _fixed(vertices[hull.vertices]))


Shape = Box | Sphere | Ellipsoid | Cylinder | Capsule | ConvexMesh
"""Any of the shapes."""
SHAPE_NAMES = ("Box", "Sphere", "Ellipsoid", "Cylinder", "Capsule", "ConvexMesh")
"""The shapes by name, for messages."""


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Something in the world that the robot must not touch.

    Raises
    ------
    InputError
        If the name is empty, the shape is none of the known ones, or the pose is not finite.
    """

    name: str
    """Name that :meth:`CollisionWorld.move` and :meth:`CollisionWorld.remove` take."""
    shape: Shape
    """Its shape, in its own frame."""
    pose: RigidTransform
    """Its frame in the world (T_world_obstacle)."""

    def __post_init__(self) -> None:
        check_name(self.name, "obstacle")
        check_shape(self.shape, self.name)
        check_pose(self.pose, self.name)


def check_name(name: str, what: str) -> None:
    """Refuse what is no name; ``what`` is told in the message."""
    if not isinstance(name, str) or not name:
        raise InputError(f"{what}: the name must be a text that is not empty, got {name!r}")


def check_shape(shape: Shape, name: str) -> None:
    """Refuse what is none of the shapes; ``name`` is told in the message."""
    if not isinstance(shape, Shape):
        raise InputError(
            f"{name}: the shape must be one of {', '.join(SHAPE_NAMES)}, got {shape!r}"
        )


def check_pose(pose: RigidTransform, name: str) -> None:
    """Refuse what is no finite single pose; ``name`` is told in the message."""
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


def _sizes(values: ArrayLike, what: str) -> NDArray[np.float64]:
    sizes = _numbers(values, what)
    if sizes.shape != (3,):
        raise InputError(f"{what} must be 3 numbers, got shape {sizes.shape}")
    for size in sizes:
        _check_size(float(size), what)
    return _fixed(sizes)


def _check_size(value: float, what: str) -> None:
    try:
        fits = not isinstance(value, str) and SMALLEST_SIZE_M <= float(value) < float("inf")
    except (TypeError, ValueError):
        fits = False
    if not fits:
        raise InputError(f"{what} must be finite and >= {SMALLEST_SIZE_M} m, got {value}")


def _numbers(values: ArrayLike, what: str) -> NDArray[np.float64]:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} must be numbers: {error}") from error
    if not np.all(np.isfinite(numbers)):
        raise InputError(f"{what} must be finite")
    return numbers


def _fixed(array: NDArray[np.float64]) -> NDArray[np.float64]:
    array.setflags(write=False)
    return array

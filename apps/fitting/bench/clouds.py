"""Generate clouds of known solids: whole surfaces, single views, outliers, tables, other shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import FreeSpace, Superquadric
from eyehand.perception.io import sample_triangles
from eyehand.perception.superquadric import Kind, sample_surface

from .compound_solids import COMPOUNDS, face_normals, posed_compound
from .odd_solids import DRAWERS, PosedSolid
from .rendered_clouds import cloud_in_air, cloud_on_table, draw_from_above, random_rotation
from .true_solid import TrueSolid, true_kind

Group = Literal[
    "full",
    "full-outliers",
    "full-outliers-1mm",
    "view-1mm",
    "view-2mm",
    "view-outliers",
    "table",
    "kinds-view",
    "mismatched",
    "compound",
]
"""A group of clouds, see :func:`fit_case`."""

MESHES = "meshes"
"""Name of the group of household meshes, see `mesh_cases`."""
EXPONENTS = (0.1, 0.3, 0.5, 1.0, 1.5)
"""Exponents of the drawn solids, along z and around z."""
SEMI_AXES = (0.015, 0.080)
"""Range of half extents, m: objects that a hand can grasp."""
DISTANCE = 0.7
"""Distance from the camera to the centre of the solid in a single view, m."""
POINTS = 1000
"""Default number of points of a cloud."""
NOISE = {"full-outliers": 0.0, "view-2mm": 0.002}
"""Standard deviation of each coordinate by group, m; DEFAULT_NOISE in all others."""
DEFAULT_NOISE = 0.001
OUTLIER_SHARE = 0.2
"""Share of points that are uniform in the doubled bounds of the solid."""


@dataclass(frozen=True)
class FitCase:
    """One cloud and its true solid."""

    group: Group | Literal["meshes"]
    seed: int
    name: str
    """Kind of solid in a word."""
    truth: TrueSolid
    points: NDArray[np.float64]
    """(N, 3), m."""
    view_origin: NDArray[np.float64] | None
    """(3,) camera position, m; None for a whole surface."""
    support_plane: NDArray[np.float64] | None
    """(4,) unit normal and offset of the support plane; None if there is none."""
    free_space: FreeSpace | None = None
    """Space that an image shows to be empty; None without an image."""
    margin: float = 0.0
    """Distance of the object's outline beyond that of the points, m."""

    @property
    def true_kind(self) -> Kind | None:
        """See :func:`true_kind`."""
        return true_kind(self.truth)


def fit_case(group: Group, seed: int, points: int = POINTS) -> FitCase:
    """Generate the cloud of a group and seed. Solid and view do not depend on `points`.

    ``full``
        Points on the whole surface of a superquadric, with random exponents of EXPONENTS, random
        semi-axes within SEMI_AXES and a random rotation. 1 mm noise in every coordinate, as in all
        groups below unless stated.
    ``full-outliers``, ``full-outliers-1mm``
        The same with a fifth of the points uniform in the doubled bounds. The other points are
        exact, or have 1 mm noise.
    ``view-1mm``, ``view-2mm``, ``view-outliers``
        The part of such a surface that faces a camera at 0.7 m. The last has outliers and 1 mm
        noise.
    ``table``
        One object settled by physics and rendered with the realistic noise of a structured-light
        camera (correlated, quantised, with flying pixels and grazing dropout), in the world frame.
        Its pixels are known. At most `points` of them are used.
    ``kinds-view``
        A sphere, cylinder, ellipsoid or box with a random rotation in the air, 0.7 m from the same
        camera. The seed selects one of the four in turn.
    ``mismatched``
        The visible part of a shape that no superquadric equals (see `odd_solids`), from 0.7 m. Half
        of them stand on a table with a known plane, the others have a random rotation in the air.
        The seed selects the shapes in turn.
    ``compound``
        The same with solids that are not convex (see `compound_solids`).

    Raises
    ------
    InputError
        If the group is unknown, the seed negative, or there are no points.
    """
    if group not in get_args(Group):
        raise InputError(f"clouds must be of {', '.join(get_args(Group))}, got {group!r}")
    if seed < 0:
        raise InputError(f"the seed of a cloud must be >= 0, got {seed}")
    if points < 1:
        raise InputError(f"a cloud must have 1 point or more, got {points}")
    if group == "mismatched":
        return _mismatched(seed, points)
    if group == "compound":
        return _compound(seed, points)
    if group not in ("table", "kinds-view"):
        return _drawn(group, seed, points)
    solid, cloud, origin, plane = (
        cloud_on_table(seed, points)
        if group == "table"
        else cloud_in_air(seed, points, DISTANCE, SEMI_AXES)
    )
    return FitCase(group, seed, solid.kind, solid, cloud, origin, plane)


def visible_points(
    solid: Superquadric,
    origin: NDArray[np.float64] | None,
    count: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Draw points (count, 3) of a surface in random order; with an origin, only facing points."""
    kept = np.zeros((0, 3))
    while len(kept) < count:
        points = sample_surface(solid, 4 * count, rng)
        if origin is not None:
            # The solids are convex, so every point that faces the camera is visible.
            facing = np.einsum("ij,ij->i", solid.normals(points), origin - points) > 0
            points = points[facing]
        kept = np.vstack([kept, points])
    return kept[rng.permutation(len(kept))[:count]]


def uniform_outliers(
    solid: Superquadric, scale: float, count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw points (count, 3) uniformly in the bounds of a solid, scaled about their middle."""
    low, high = -solid.support(-np.eye(3)), solid.support(np.eye(3))
    middle, half = (low + high) / 2, (high - low) / 2
    return middle + scale * half * rng.uniform(-1, 1, (count, 3))


def _drawn(group: Group, seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 17])
    solid = _random_solid(rng)
    # Drawn for whole surfaces too, so that all groups have the same solids.
    direction = rng.normal(size=3)
    origin = None
    if group.startswith("view"):
        origin = solid.centre + DISTANCE * direction / np.linalg.norm(direction)
    points = visible_points(solid, origin, count, rng)
    points = points + rng.normal(size=points.shape) * NOISE.get(group, DEFAULT_NOISE)
    if "outliers" in group:
        outliers = round(OUTLIER_SHARE * count)
        points[:outliers] = uniform_outliers(solid, 2.0, outliers, rng)
        points = points[rng.permutation(count)]
    return FitCase(group, seed, true_kind(solid) or "", solid, points, origin, None)


def _random_solid(rng: np.random.Generator) -> Superquadric:
    semi_axes = rng.uniform(*SEMI_AXES, 3)
    exponents = (float(rng.choice(EXPONENTS)), float(rng.choice(EXPONENTS)))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), random_rotation(rng))
    return Superquadric(semi_axes, exponents, pose)


def _mismatched(seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 19])
    name = list(DRAWERS)[seed % len(DRAWERS)]
    shape = DRAWERS[name](rng)
    pose, towards, plane = _random_placement(-shape.corners()[:, 2].min(), rng)
    solid = PosedSolid(shape, pose)
    origin = solid.centre + DISTANCE * towards
    vertices, faces = solid.mesh()
    away = origin - vertices[faces[:, 0]]
    facing = np.einsum("ij,ij->i", face_normals(vertices, faces), away) > 0
    points = sample_triangles(vertices, faces[facing], count, rng)
    points = points + DEFAULT_NOISE * rng.normal(size=points.shape)
    return FitCase("mismatched", seed, name, solid, points, origin, plane)


def _compound(seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 29])
    name = list(COMPOUNDS)[seed % len(COMPOUNDS)]
    parts = COMPOUNDS[name](rng)
    down = np.array([0.0, 0.0, -1.0])
    height = max(float(part.support(down)) for part in parts)
    pose, towards, plane = _random_placement(height, rng)
    solid = posed_compound(parts, pose)
    origin = solid.centre + DISTANCE * towards
    points = solid.surface_points(origin, count, rng)
    points = points + DEFAULT_NOISE * rng.normal(size=points.shape)
    return FitCase("compound", seed, name, solid, points, origin, plane)


def _random_placement(
    height: float, rng: np.random.Generator
) -> tuple[RigidTransform, NDArray[np.float64], NDArray[np.float64] | None]:
    """Draw a placement of a shape: on a table or in the air, with equal probability.

    Parameters
    ----------
    height
        Height of the shape's origin above its lowest point, m.
    rng
        Source of randomness.

    Returns
    -------
    pose, towards, plane
        Pose of the shape, unit vector (3,) to the camera, and the plane (4,) of the table.
    """
    on_table = bool(rng.random() < 0.5)
    place = rng.uniform(-0.2, 0.2, 3)
    if on_table:
        place[2] = height
        turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0, 2 * np.pi)])
        plane = np.array([0.0, 0.0, 1.0, 0.0])
        return RigidTransform.from_components(place, turn), draw_from_above(rng), plane
    turn, towards = random_rotation(rng), rng.normal(size=3)
    pose = RigidTransform.from_components(place, turn)
    return pose, towards / np.linalg.norm(towards), None

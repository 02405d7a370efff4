"""Generate clouds of known solids: whole surfaces, single views, outliers, tables, other shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import Superquadric
from eyehand.perception.io import sample_triangles
from eyehand.perception.superquadric import sample_surface

from .compound_solids import COMPOUNDS, posed_compound
from .odd_solids import DRAWERS, PosedSolid
from .rendered_clouds import cloud_in_air, cloud_on_table, draw_from_above
from .true_solid import true_kind

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception.superquadric import Kind

    from .true_solid import TrueSolid

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

    group: Group
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
    if group == "table":
        return _rendered(group, seed, *cloud_on_table(seed, points))
    if group == "kinds-view":
        return _rendered(group, seed, *cloud_in_air(seed, points, DISTANCE, SEMI_AXES))
    if group == "mismatched":
        return _mismatched(seed, points)
    if group == "compound":
        return _compound(seed, points)
    return _drawn(group, seed, points)


def seen_points(
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


def _drawn(group: Group, seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 17])
    solid = _random_solid(rng)
    # Drawn for whole surfaces too, so that all groups have the same solids.
    direction = rng.normal(size=3)
    origin = None
    if group.startswith("view"):
        origin = solid.centre + DISTANCE * direction / np.linalg.norm(direction)
    points = seen_points(solid, origin, count, rng)
    points = points + rng.normal(size=points.shape) * NOISE.get(group, DEFAULT_NOISE)
    if "outliers" in group:
        wrong = round(OUTLIER_SHARE * count)
        low, high = -solid.support(-np.eye(3)), solid.support(np.eye(3))
        middle, half = (low + high) / 2, (high - low) / 2
        points[:wrong] = middle + 2 * half * rng.uniform(-1, 1, (wrong, 3))
        points = points[rng.permutation(count)]
    return FitCase(group, seed, true_kind(solid) or "", solid, points, origin, None)


def _random_solid(rng: np.random.Generator) -> Superquadric:
    semi_axes = rng.uniform(*SEMI_AXES, 3)
    exponents = (float(rng.choice(EXPONENTS)), float(rng.choice(EXPONENTS)))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), _random_rotation(rng))
    return Superquadric(semi_axes, exponents, pose)


def _rendered(
    group: Group,
    seed: int,
    solid: Superquadric,
    points: NDArray[np.float64],
    origin: NDArray[np.float64],
    plane: NDArray[np.float64] | None,
) -> FitCase:
    return FitCase(group, seed, solid.kind, solid, points, origin, plane)


def _mismatched(seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 19])
    names = list(DRAWERS)
    name = names[seed % len(names)]
    shape = DRAWERS[name](rng)
    on_table = bool(rng.random() < 0.5)
    place = rng.uniform(-0.2, 0.2, 3)
    if on_table:
        place[2] = -shape.corners()[:, 2].min()
    turn, towards = _random_view(on_table, rng)
    solid = PosedSolid(shape, RigidTransform.from_components(place, turn))
    origin = solid.centre + DISTANCE * towards
    vertices, faces = solid.mesh()
    first, second, third = np.moveaxis(vertices[faces], 1, 0)
    outward = np.cross(second - first, third - first)
    facing = np.einsum("ij,ij->i", outward, origin - first) > 0
    points = sample_triangles(vertices, faces[facing], count, rng)
    points = points + DEFAULT_NOISE * rng.normal(size=points.shape)
    plane = np.array([0.0, 0.0, 1.0, 0.0]) if on_table else None
    return FitCase("mismatched", seed, name, solid, points, origin, plane)


def _compound(seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 29])
    names = list(COMPOUNDS)
    name = names[seed % len(names)]
    parts = COMPOUNDS[name](rng)
    on_table = bool(rng.random() < 0.5)
    place = rng.uniform(-0.2, 0.2, 3)
    turn, towards = _random_view(on_table, rng)
    if on_table:
        down = np.array([0.0, 0.0, -1.0])
        place[2] = max(float(part.support(down)) for part in parts)
    solid = posed_compound(parts, RigidTransform.from_components(place, turn))
    origin = solid.centre + DISTANCE * towards
    points = solid.surface_points(origin, count, rng)
    points = points + DEFAULT_NOISE * rng.normal(size=points.shape)
    plane = np.array([0.0, 0.0, 1.0, 0.0]) if on_table else None
    return FitCase("compound", seed, name, solid, points, origin, plane)


def _random_view(on_table: bool, rng: np.random.Generator) -> tuple[Rotation, NDArray[np.float64]]:
    """Draw the rotation of a solid and the direction (3,) to the camera."""
    if on_table:
        turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0, 2 * np.pi)])
        return turn, draw_from_above(rng)
    turn = _random_rotation(rng)
    towards = rng.normal(size=3)
    return turn, towards / np.linalg.norm(towards)


def _random_rotation(rng: np.random.Generator) -> Rotation:
    return Rotation.from_quat(rng.normal(size=4))

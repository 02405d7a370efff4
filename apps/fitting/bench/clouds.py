"""Clouds with known solids: whole surfaces, single views, outliers, tables, odd shapes."""

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
"""See :func:`fit_case`."""

EXPONENTS = (0.1, 0.3, 0.5, 1.0, 1.5)
"""Exponents that solids are drawn from, along z and around it."""
SEMI_AXES = (0.015, 0.080)
"""Smallest and largest half extent, m: what a hand grasps."""
DISTANCE = 0.7
"""From the camera to the middle of what it sees in a single view, m."""
POINTS = 1000
"""Points of a cloud when nothing else is asked for."""
NOISE = {"full-outliers": 0.0, "view-2mm": 0.002}
"""Standard deviation of each coordinate by group, m; 1 mm in all others."""
USUAL_NOISE = 0.001
OUTLIER_SHARE = 0.2
"""Share of points that lie anywhere in the doubled bounds of the solid."""


@dataclass(frozen=True)
class FitCase:
    """One cloud, and the solid it was taken from."""

    group: Group
    seed: int
    name: str
    """What the solid is, in a word."""
    truth: TrueSolid
    points: NDArray[np.float64]
    """(N, 3), m."""
    view_origin: NDArray[np.float64] | None
    """(3,) place of the camera, m; None for a whole surface."""
    support_plane: NDArray[np.float64] | None
    """(4,) unit normal and offset of what the solid rests on, where it rests on something."""

    @property
    def true_kind(self) -> Kind | None:
        """See :func:`true_kind`."""
        return true_kind(self.truth)


def fit_case(group: Group, seed: int, points: int = POINTS) -> FitCase:
    """Make the cloud of a group and seed; the solid and the view do not depend on `points`.

    ``full``
        Points all over a superquadric with any exponents of EXPONENTS, any semi-axes within
        SEMI_AXES, anyhow turned; 1 mm noise in every coordinate, as in all that follow.
    ``full-outliers``, ``full-outliers-1mm``
        The same with a fifth of the points anywhere in the doubled bounds, the others exact or
        with noise.
    ``view-1mm``, ``view-2mm``, ``view-outliers``
        What a camera at 0.7 m sees of such a superquadric: the side of its surface that faces
        it; the last with outliers and 1 mm.
    ``table``
        One object settled by physics and rendered with the realistic noise of a structured-light
        camera (correlated, quantised, with flying pixels and grazing dropout), in the world
        frame, its pixels known; at most `points` of them.
    ``kinds-view``
        A sphere, cylinder, ellipsoid or box anyhow turned in the air, 0.7 m before the same
        camera; the four take turns with the seed.
    ``mismatched``
        What a camera at 0.7 m sees of a shape that no superquadric is (see `odd_solids`), standing
        on a table with a known plane when the draw is even, anyhow turned in the air otherwise; the
        shapes take turns with the seed.
    ``compound``
        The same of solids that are not convex (see `compound_solids`).

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
    """Draw points (count, 3) of a surface in any order, only those that face a view's origin."""
    kept = np.zeros((0, 3))
    while len(kept) < count:
        points = sample_surface(solid, 4 * count, rng)
        if origin is not None:
            # The solids are convex: what faces the camera is seen.
            facing = np.einsum("ij,ij->i", solid.normals(points), origin - points) > 0
            points = points[facing]
        kept = np.vstack([kept, points])
    return kept[rng.permutation(len(kept))[:count]]


def _drawn(group: Group, seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 17])
    solid = _random_solid(rng)
    # Drawn for whole surfaces too, so that all groups see the same solids.
    direction = rng.normal(size=3)
    origin = None
    if group.startswith("view"):
        origin = solid.centre + DISTANCE * direction / np.linalg.norm(direction)
    points = seen_points(solid, origin, count, rng)
    points = points + rng.normal(size=points.shape) * NOISE.get(group, USUAL_NOISE)
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
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), _any_rotation(rng))
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
    turn, towards = _turned_and_seen(on_table, rng)
    solid = PosedSolid(shape, RigidTransform.from_components(place, turn))
    origin = solid.centre + DISTANCE * towards
    vertices, faces = solid.mesh()
    first, second, third = np.moveaxis(vertices[faces], 1, 0)
    outward = np.cross(second - first, third - first)
    facing = np.einsum("ij,ij->i", outward, origin - first) > 0
    points = sample_triangles(vertices, faces[facing], count, rng)
    points = points + USUAL_NOISE * rng.normal(size=points.shape)
    plane = np.array([0.0, 0.0, 1.0, 0.0]) if on_table else None
    return FitCase("mismatched", seed, name, solid, points, origin, plane)


def _compound(seed: int, count: int) -> FitCase:
    rng = np.random.default_rng([seed, 29])
    names = list(COMPOUNDS)
    name = names[seed % len(names)]
    parts = COMPOUNDS[name](rng)
    on_table = bool(rng.random() < 0.5)
    place = rng.uniform(-0.2, 0.2, 3)
    turn, towards = _turned_and_seen(on_table, rng)
    if on_table:
        down = np.array([0.0, 0.0, -1.0])
        place[2] = max(float(part.support(down)) for part in parts)
    solid = posed_compound(parts, RigidTransform.from_components(place, turn))
    origin = solid.centre + DISTANCE * towards
    points = solid.surface_points(origin, count, rng)
    points = points + USUAL_NOISE * rng.normal(size=points.shape)
    plane = np.array([0.0, 0.0, 1.0, 0.0]) if on_table else None
    return FitCase("compound", seed, name, solid, points, origin, plane)


def _turned_and_seen(
    on_table: bool, rng: np.random.Generator
) -> tuple[Rotation, NDArray[np.float64]]:
    """Draw how a solid is turned and the direction (3,) to the camera."""
    if on_table:
        turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0, 2 * np.pi)])
        return turn, draw_from_above(rng)
    turn = _any_rotation(rng)
    towards = rng.normal(size=3)
    return turn, towards / np.linalg.norm(towards)


def _any_rotation(rng: np.random.Generator) -> Rotation:
    return Rotation.from_quat(rng.normal(size=4))

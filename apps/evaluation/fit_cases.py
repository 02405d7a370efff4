"""Clouds with known solids: whole surfaces, single views, outliers, objects on a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import DepthNoise, TabletopOptions, make_scene, render_frame
from eyehand.errors import InputError
from eyehand.perception import Superquadric
from eyehand.perception.superquadric import sample_surface

if TYPE_CHECKING:
    from numpy.typing import NDArray

Group = Literal["full", "view-1mm", "view-2mm", "outliers", "table"]

EXPONENTS = (0.1, 0.3, 0.5, 1.0, 1.5)
"""Exponents that solids are drawn from, along z and around it."""
SEMI_AXES = (0.015, 0.080)
"""Smallest and largest half extent, m: what a hand grasps."""
DISTANCE = 0.7
"""Distance of a single view, m."""
POINTS = 1000
"""Points of a cloud."""
OVERSAMPLING = 4
"""A view keeps the half of a surface that faces it: this many points leave enough."""
OUTLIER_SHARE = 0.2
"""Share of points anywhere in the doubled bounds of the solid, in group ``outliers``."""


@dataclass(frozen=True)
class FitCase:
    """One cloud, and the solid it was taken from."""

    group: Group
    seed: int
    truth: Superquadric
    points: NDArray[np.float64]
    """(N, 3), m."""
    view_origin: NDArray[np.float64] | None
    """(3,) place of the camera, m; None for a whole surface."""
    support_plane: NDArray[np.float64] | None
    """(4,) unit normal and offset of what the solid rests on, where it rests on something."""


def fit_case(group: Group, seed: int) -> FitCase:
    """Make the cloud of a group and seed.

    ``full``: the whole surface, 1 mm noise. ``view-1mm``, ``view-2mm``: what a camera at 0.7 m
    sees, by the side of the surface that faces it. ``outliers``: a view with 1 mm noise and 20 %
    of points anywhere. ``table``: one object settled by physics, rendered with the realistic
    noise of a structured-light camera, in the world frame.
    """
    if group == "table":
        return _table_case(seed)
    rng = np.random.default_rng([seed, 17])
    solid = _random_solid(rng)
    points = sample_surface(solid, OVERSAMPLING * POINTS, rng)
    origin = None
    if group != "full":
        direction = rng.normal(size=3)
        origin = solid.centre + DISTANCE * direction / np.linalg.norm(direction)
        facing = np.einsum("ij,ij->i", solid.normals(points), origin - points) > 0
        points = points[facing]
    points = points[rng.permutation(len(points))[:POINTS]]
    points = points + rng.normal(size=points.shape) * (0.002 if group == "view-2mm" else 0.001)
    if group == "outliers":
        reach = 2 * solid.semi_axes.max()
        wrong = rng.random(len(points)) < OUTLIER_SHARE
        points[wrong] = solid.centre + rng.uniform(-reach, reach, (int(wrong.sum()), 3))
    return FitCase(group, seed, solid, points, origin, None)


def _random_solid(rng: np.random.Generator) -> Superquadric:
    semi_axes = rng.uniform(*SEMI_AXES, 3)
    exponents = (float(rng.choice(EXPONENTS)), float(rng.choice(EXPONENTS)))
    rotation = Rotation.from_quat(rng.normal(size=4))
    pose = RigidTransform.from_components(rng.uniform(-0.2, 0.2, 3), rotation)
    return Superquadric(semi_axes, exponents, pose)


def _table_case(seed: int) -> FitCase:
    scene = make_scene(seed, TabletopOptions(family="dropped", count_range=(1, 1)))
    frame, labels = render_frame(scene, DepthNoise.realistic(), seed, colour=False)
    pose = frame.T_world_camera
    if pose is None:
        raise InputError("a rendered table must know its camera's place, got none")
    points = pose.apply(frame.points()[(labels == 1) & frame.valid].astype(np.float64))
    rng = np.random.default_rng([seed, 18])
    points = points[rng.permutation(len(points))[:POINTS]]
    plane = np.array([0.0, 0.0, 1.0, 0.0])
    return FitCase("table", seed, scene.objects[0].shape, points, pose.translation, plane)

"""Render clouds of single objects with the errors of a structured-light camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import (
    DepthNoise,
    Table,
    TabletopObject,
    TabletopOptions,
    TabletopScene,
    ViewOptions,
    look_at,
    make_scene,
    open_renderer,
    render_frame,
)
from eyehand.data_synth.scenes import camera_intrinsics
from eyehand.errors import InputError
from eyehand.perception import Superquadric
from eyehand.perception.superquadric import MIN_EXPONENT, Kind

TABLE_KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""Kinds of objects on tables, drawn at random."""
AIR_KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box")
"""Kinds of solids in the air. The seed selects them in turn."""
HEIGHT = 0.35
"""Height of a solid in the air above the table, m. The table is then the background."""
ELEVATIONS = (np.pi / 6, 65 * np.pi / 180)
"""Range of the camera elevation above the object, rad."""


def cloud_on_table(
    seed: int, points: int
) -> tuple[Superquadric, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Render one object that fell onto a table.

    Parameters
    ----------
    seed
        Seed of the object, its fall, the view and the noise.
    points
        Maximum number of points.

    Returns
    -------
    solid, cloud, view_origin, support_plane
        The solid, points (N, 3) and camera position (3,), in the world frame, m; the table (4,).
    """
    options = TabletopOptions(family="dropped", count_range=(1, 1), kinds=TABLE_KINDS)
    scene = make_scene(seed, options)
    plane = np.array([0.0, 0.0, 1.0, -scene.table.height])
    return scene.objects[0].shape, *_render_cloud(scene, points), plane


def cloud_in_air(
    seed: int, points: int, distance: float, semi_axes: tuple[float, float]
) -> tuple[Superquadric, NDArray[np.float64], NDArray[np.float64], None]:
    """Render one simple solid in the air with a random rotation.

    Parameters
    ----------
    seed
        Seed of the solid, its rotation, the view and the noise. It also selects the kind.
    points
        Maximum number of points.
    distance
        Distance from the camera to the centre of the solid, m.
    semi_axes
        Minimum and maximum semi-axis, m.

    Returns
    -------
    solid, cloud, view_origin, support_plane
        As for :func:`cloud_on_table`; the plane is None.
    """
    rng = np.random.default_rng([seed, 23])
    solid = _simple_solid(AIR_KINDS[seed % len(AIR_KINDS)], semi_axes, rng)
    towards = draw_from_above(rng)
    item = TabletopObject(solid.kind, solid, 1.0, (0.5, 0.5, 0.5))
    camera = camera_intrinsics(ViewOptions())
    pose = look_at(solid.centre + distance * towards, solid.centre)
    scene = TabletopScene(seed, "separate", (item,), Table(), camera, pose)
    return solid, *_render_cloud(scene, points), None


def draw_from_above(rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw the direction (3,) from an object to a camera above it."""
    return view_direction(rng.uniform(0, 2 * np.pi), rng.uniform(*ELEVATIONS))


def view_direction(azimuth: float, elevation: float) -> NDArray[np.float64]:
    """Return the unit vector (3,) from an object to a camera; angles in rad."""
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def random_rotation(rng: np.random.Generator) -> Rotation:
    """Draw a rotation, uniform over all rotations."""
    return Rotation.from_quat(rng.normal(size=4))


def _simple_solid(
    kind: Kind, semi_axes: tuple[float, float], rng: np.random.Generator
) -> Superquadric:
    a1, a2, a3 = rng.uniform(*semi_axes, 3)
    if kind == "sphere":
        a2 = a3 = a1
    elif kind == "cylinder":
        a2 = a1
    edge = MIN_EXPONENT
    exponents = {"cylinder": (edge, 1.0), "box": (edge, edge)}.get(kind, (1.0, 1.0))
    pose = RigidTransform.from_components([0.0, 0.0, HEIGHT], random_rotation(rng))
    return Superquadric(np.array([a1, a2, a3]), exponents, pose, kind)


def _render_cloud(
    scene: TabletopScene, points: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return points (N, 3) of the first object and the camera position (3,), in the world, m."""
    # The ray caster gives the same depth on every machine. Graphics cards differ in the last bits.
    renderer = open_renderer("rays")
    frame, labels = render_frame(
        scene, DepthNoise.realistic(), scene.seed, renderer=renderer, colour=False
    )
    pose = frame.T_world_camera
    if pose is None:
        raise InputError("a rendered frame must have a camera pose, got None")
    cloud = pose.apply(frame.points()[(labels == 1) & frame.valid].astype(np.float64))
    rng = np.random.default_rng([scene.seed, 18])
    return cloud[rng.permutation(len(cloud))[:points]], np.asarray(pose.translation)

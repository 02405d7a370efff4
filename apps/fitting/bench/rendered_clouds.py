"""Clouds of single objects as a structured-light camera gives them, every error included."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
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
from eyehand.perception.superquadric import MIN_EXPONENT

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception.superquadric import Kind

TABLE_KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box", "superquadric")
"""What lies on the tables, by chance."""
AIR_KINDS: tuple[Kind, ...] = ("sphere", "cylinder", "ellipsoid", "box")
"""What hangs in the air, in turns."""
HEIGHT = 0.35
"""How far above the table it hangs, m: behind its outline there is something, far away."""
ELEVATIONS = (np.pi / 6, 65 * np.pi / 180)
"""How steeply a camera looks down, rad: as on the tables."""


def cloud_on_table(
    seed: int, points: int
) -> tuple[Superquadric, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Let one object fall on a table and look at it.

    Parameters
    ----------
    seed
        Source of the object, its fall, the view and the noise.
    points
        At most so many points are kept.

    Returns
    -------
    solid, cloud, view_origin, support_plane
        The solid, (N, 3) points, (3,) camera, all in the world frame, m; (4,) the table.
    """
    options = TabletopOptions(family="dropped", count_range=(1, 1), kinds=TABLE_KINDS)
    scene = make_scene(seed, options)
    plane = np.array([0.0, 0.0, 1.0, -scene.table.height])
    return scene.objects[0].shape, *_look(scene, points), plane


def cloud_in_air(
    seed: int, points: int, distance: float, semi_axes: tuple[float, float]
) -> tuple[Superquadric, NDArray[np.float64], NDArray[np.float64], None]:
    """Hang one simple solid in the air, anyhow turned, and look at it.

    Parameters
    ----------
    seed
        Source of the solid, its rotation, the view and the noise; the kinds take turns with it.
    points
        At most so many points are kept.
    distance
        From the camera to the solid's middle, m.
    semi_axes
        Least and largest semi-axis, m.

    Returns
    -------
    solid, cloud, view_origin, support_plane
        As of :func:`cloud_on_table`; there is no support.
    """
    rng = np.random.default_rng([seed, 23])
    solid = _simple_solid(AIR_KINDS[seed % len(AIR_KINDS)], semi_axes, rng)
    towards = draw_from_above(rng)
    item = TabletopObject(solid.kind, solid, 1.0, (0.5, 0.5, 0.5))
    camera = camera_intrinsics(ViewOptions())
    pose = look_at(solid.centre + distance * towards, solid.centre)
    scene = TabletopScene(seed, "separate", (item,), Table(), camera, pose)
    return solid, *_look(scene, points), None


def draw_from_above(rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw the direction (3,) from an object to a camera that looks down on it."""
    azimuth, elevation = rng.uniform(0, 2 * np.pi), rng.uniform(*ELEVATIONS)
    level = np.cos(elevation)
    return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


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
    rotation = Rotation.from_quat(rng.normal(size=4))
    pose = RigidTransform.from_components([0.0, 0.0, HEIGHT], rotation)
    return Superquadric(np.array([a1, a2, a3]), exponents, pose, kind)


def _look(scene: TabletopScene, points: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (N, 3) of the first object, and the camera's place (3,), both in the world."""
    # Rays see the same on every machine; graphics cards differ in the last bits of depth.
    renderer = open_renderer("rays")
    frame, labels = render_frame(
        scene, DepthNoise.realistic(), scene.seed, renderer=renderer, colour=False
    )
    pose = frame.T_world_camera
    if pose is None:
        raise InputError("a rendered table must know its camera's place, got none")
    cloud = pose.apply(frame.points()[(labels == 1) & frame.valid].astype(np.float64))
    rng = np.random.default_rng([scene.seed, 18])
    return cloud[rng.permutation(len(cloud))[:points]], np.asarray(pose.translation)

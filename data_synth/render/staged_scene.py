"""Scenes with given objects and exact poses, without physics and randomness."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics, DepthFrame

from ..mujoco_import import import_mujoco
from ..scenes.staged_solids import Ball, Part, StagedSolid
from ..scenes.tabletop_options import ViewOptions
from ..scenes.tabletop_scene import Table
from ..scenes.tabletop_spec import tabletop_spec
from ..scenes.viewpoint import camera_intrinsics, look_at
from .depth_noise import DepthNoise, add_depth_noise, axial_sigma
from .depth_renderer import DEFAULT_MAX_RANGE_M, open_renderer
from .rendered_view import RenderedView

MIN_VERTICAL_ANGLE = 1e-6
"""Minimum angle between line of sight and vertical, rad; below it the image has no upright
direction."""
MAX_CACHED_VIEWS = 24
"""Noise-free views kept for the next call: 2.5 MB each at 640x480."""


@dataclass(frozen=True)
class StagedObject:
    """A solid and its pose."""

    solid: StagedSolid
    """The solid."""
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position of its foot's centre in the world, m; the table's top is at z = 0."""
    yaw: float = 0.0
    """Rotation about the world's z-axis, rad, after `lean`."""
    lean: float = 0.0
    """Rotation about its own y-axis, rad; tilts its top towards its own +x."""
    colour: tuple[float, float, float] = (0.72, 0.24, 0.2)
    """Red, green, blue, each in [0, 1]."""

    @property
    def rotation(self) -> Rotation:
        """Rotation, world from solid."""
        return Rotation.from_euler("ZY", [self.yaw, self.lean])


@dataclass(frozen=True)
class StagedView:
    """Camera pose and image of a staged scene.

    Raises
    ------
    InputError
        If the camera would look straight up or down, or from no distance.
    """

    elevation: float = np.pi / 4
    """Angle of the line of sight below the horizon, rad."""
    azimuth: float = -np.pi / 2
    """Direction from the target to the camera about the world's z-axis, rad; -π/2 is on -y."""
    distance: float = 0.8
    """Distance to the target, m."""
    target: tuple[float, float, float] = (0.0, 0.0, 0.04)
    """World point on the optical axis, m."""
    image_size: tuple[int, int] = (640, 480)
    """Columns and rows, px."""
    shift: tuple[float, float] = (0.0, 0.0)
    """Shift of the image on the sensor plane, px to the right and down. It crops the view without
    changing the perspective."""

    def __post_init__(self) -> None:
        if not 0 < self.distance < np.inf:
            raise InputError(f"distance must be > 0 m and finite, got {self.distance}")
        if not abs(self.elevation) < np.pi / 2 - MIN_VERTICAL_ANGLE:
            raise InputError(
                "elevation must lie within (-π/2, π/2) rad, for straight down has no upright "
                f"image, got {self.elevation}"
            )

    @property
    def intrinsics(self) -> CameraIntrinsics:
        """Intrinsics of the camera."""
        k = camera_intrinsics(ViewOptions(image_size=self.image_size))
        right, down = self.shift
        return CameraIntrinsics(k.fx, k.fy, k.cx + right, k.cy + down, k.width, k.height)

    @property
    def pose(self) -> RigidTransform:
        """T_world_camera."""
        level = np.cos(self.elevation)
        towards = [level * np.cos(self.azimuth), level * np.sin(self.azimuth)]
        return look_at(
            np.add(self.target, np.multiply(self.distance, [*towards, np.sin(self.elevation)])),
            self.target,
        )


@dataclass(frozen=True)
class StagedScene:
    """Objects on a table with exact poses, and one camera."""

    objects: tuple[StagedObject, ...]
    """Label k of the view is object k-1."""
    view: StagedView = field(default_factory=StagedView)
    """The camera."""
    table: Table = field(default_factory=Table)
    """The table."""


def staged_frame(
    scene: StagedScene,
    noise: DepthNoise | None = None,
    seed: int = 0,
    *,
    colour: bool = False,
) -> tuple[DepthFrame, NDArray[np.int32]]:
    """Take a depth image of a staged scene, with the true label of every pixel.

    Parameters
    ----------
    scene
        The scene.
    noise
        The camera's errors; none when not given.
    seed
        Source of the noise, >= 0; the same seed gives the same image.
    colour
        Whether to draw colours too, which takes most of the time.

    Returns
    -------
    frame, labels
        The frame with `T_world_camera`, and (H, W) int32 labels of the noise-free view: 0 table
        and floor, k object k-1.

    Raises
    ------
    InputError
        If the seed is negative, or no reading is left.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    clean = render_staged(scene, colour=colour)
    intrinsics = scene.view.intrinsics
    rng = np.random.default_rng(seed)
    depth = add_depth_noise(clean.depth, intrinsics, rng, noise or DepthNoise.none())
    frame = DepthFrame(depth, intrinsics, scene.view.pose, clean.colour)
    return frame, clean.labels


def noise_at_one_metre(sigma: float) -> DepthNoise:
    """Return noise, independent in each pixel, with standard deviation `sigma` (m) at 1 m.

    It grows with distance as Nguyen's does (see `depth_noise`).
    """
    return DepthNoise(axial=sigma / float(axial_sigma(np.array(1.0))))


@functools.lru_cache(maxsize=MAX_CACHED_VIEWS)
def render_staged(scene: StagedScene, *, colour: bool = False) -> RenderedView:
    """Render by ray casting on the CPU, which gives the same image on every machine.

    Parameters
    ----------
    scene
        The scene.
    colour
        Whether to draw colours too.

    Returns
    -------
    RenderedView
        Depth, labels (0 table and floor, k object k-1), colour; shared between calls, read-only.

    Raises
    ------
    DeviceError
        If MuJoCo cannot be loaded.
    """
    mujoco = import_mujoco()
    spec = tabletop_spec((), scene.table, free=False)
    for number, item in enumerate(scene.objects):
        body = spec.worldbody.add_body(name=f"object_{number}")
        body.pos = np.add(item.at, [0.0, 0.0, scene.table.height])
        body.quat = item.rotation.as_quat(scalar_first=True)
        for index, part in enumerate(item.solid.parts):
            _add_part(mujoco, spec, body, f"object_{number}_{index}", part, item.colour)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # Bodies are numbered in the order they were added, after the world.
    view = open_renderer("rays").render(
        model,
        data,
        scene.view.intrinsics,
        scene.view.pose,
        model.geom_bodyid.astype(np.int32),
        max_range=DEFAULT_MAX_RANGE_M,
        colour=colour,
    )
    for image in (view.depth, view.labels, view.colour):
        if image is not None:
            image.setflags(write=False)
    return view


def _add_part(
    mujoco: Any,
    spec: Any,
    body: Any,
    name: str,
    part: Part,
    colour: tuple[float, float, float],
) -> None:
    geom = body.add_geom(name=name, contype=0, conaffinity=0)
    geom.rgba = [*colour, 1.0]
    if isinstance(part, Ball):
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [part.radius, 0, 0]
        geom.pos = [0.0, 0.0, part.radius]
        return
    vertices, faces = part.mesh()
    mesh = spec.add_mesh(name=name, uservert=vertices.ravel(), userface=faces.ravel())
    # Thin walls have too little volume for MuJoCo; nothing moves here, so a shell will do.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name

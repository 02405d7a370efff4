"""Random scenes of objects in and on furniture, drawn from a seed and settled by physics."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

from .arm_in_view import FOOT_PARTS, draw_arm
from .fixture import Colour, Fixture
from .furnished_scene import FurnishedOptions, FurnishedScene, RigidObject, object_pose
from .furnished_settings import FULL_COUNT, HALF_VIEW, Setting, draw_setting
from .household_shapes import draw_shape
from .mesh_object import MeshObject
from .pouring import FurnishedPhysics, pour
from .tabletop import PALETTE
from .tabletop_options import TabletopOptions, ViewOptions
from .tabletop_scene import TabletopObject, solid_volume
from .viewpoint import MIN_VISIBLE_SHARE, camera_intrinsics, look_at, reduced

MAX_DRAWS = 20
"""Draws before :func:`make_furnished_scene` gives up."""
MIN_SEEN = 0.5
"""Minimum share of the objects of which the camera sees more than a few pixels. Heaps hide some."""
ARM_SHARES = (0.01, 0.3)
"""Minimum and maximum share of the image that a robot arm covers."""
DARK_SHARE = 0.12
"""Share of objects that are nearly black, where some cameras read nothing."""

_VIEWS = 15
"""Camera poses tried for one draw."""
_FILLED = (0.85, 1.3)
"""Range of the radius of interest over half the height of the image."""
_DARK = ((0.05, 0.05, 0.06), (0.09, 0.07, 0.06), (0.04, 0.06, 0.10))
_REDUCTION = 4


def make_furnished_scene(seed: int, options: FurnishedOptions | None = None) -> FurnishedScene:
    """Draw a scene whose objects are at rest in and on furniture.

    Objects fall one by one and settle in MuJoCo. Those that fall off the furniture are removed. A
    draw is rejected and repeated if fewer objects stay than requested, if they do not come to
    rest, or if no camera pose shows half of them. Heaped objects may be hidden. The same seed and
    options give the same scene on one machine.

    Parameters
    ----------
    seed
        Source of all randomness, >= 0.
    options
        Furniture, number and source of the objects.

    Raises
    ------
    InputError
        If the seed is negative, or all draws failed (the message counts the reasons).
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    options = options or FurnishedOptions()
    faults: Counter[str] = Counter()
    for attempt in range(MAX_DRAWS):
        drawn = _draw(int(seed), attempt, options)
        if isinstance(drawn, FurnishedScene):
            return drawn
        faults[drawn] += 1
    counts = ", ".join(f"{count}x {fault}" for fault, count in faults.most_common())
    low, high = options.counts
    raise InputError(
        f"no {options.family} scene of {low}-{high} objects in {MAX_DRAWS} draws ({counts}): ask "
        "for fewer or smaller objects"
    )


def _draw(seed: int, attempt: int, options: FurnishedOptions) -> FurnishedScene | str:
    """Draw once; return the scene, or the reason for its rejection."""
    rng = np.random.default_rng([seed, attempt, zlib.crc32(options.family.encode())])
    low, high = options.counts
    count = int(rng.integers(low, high + 1))
    setting = draw_setting(options.family, count, rng)
    if setting.full:
        count = FULL_COUNT if options.count_range is None else high
    objects = [_draw_object(k, setting, options, rng) for k in range(count)]
    physics = FurnishedPhysics(objects, setting.fixtures)
    stayed = pour(objects, setting.zones, physics, rng)
    if isinstance(stayed, str):
        return stayed
    if len(stayed) < low:
        return "too many fell off"
    intrinsics = camera_intrinsics(ViewOptions(image_size=options.image_size))
    for _ in range(_VIEWS):
        azimuth, T_world_camera = _draw_view(setting, rng)
        fixtures = setting.fixtures
        if options.arm:
            arm = draw_arm(setting, azimuth, rng)
            if arm is None:
                return "no posture of the arm"
            fixtures = (*fixtures, *arm)
        if _shows(stayed, fixtures, intrinsics, T_world_camera):
            return FurnishedScene(
                seed, options.family, stayed, fixtures, intrinsics, T_world_camera
            )
    return "no view of half of the objects"


def _draw_object(
    index: int, setting: Setting, options: FurnishedOptions, rng: np.random.Generator
) -> RigidObject:
    colour: Colour = PALETTE[rng.integers(len(PALETTE))]
    if rng.random() < DARK_SHARE:
        colour = _DARK[rng.integers(len(_DARK))]
    if options.meshes and rng.random() < options.mesh_share:
        item = options.meshes[rng.integers(len(options.meshes))]
        name = f"{item.name}_{index + 1}"
        still = RigidTransform.identity()
        return MeshObject(name, item.vertices, item.faces, item.mass, colour, still, item.pieces)
    solids = TabletopOptions(width_range=setting.width_range, height_range=setting.height_range)
    shape = draw_shape(solids.kinds[rng.integers(len(solids.kinds))], solids, rng)
    mass = float(rng.uniform(*solids.density_range)) * solid_volume(shape)
    return TabletopObject(f"{shape.kind}_{index + 1}", shape, mass, colour)


def _draw_view(setting: Setting, rng: np.random.Generator) -> tuple[float, RigidTransform]:
    """Return the azimuth of a camera, rad, and T_world_camera."""
    azimuth = rng.uniform(*setting.azimuth)
    elevation = rng.uniform(*setting.elevation)
    distance = setting.radius / (HALF_VIEW * rng.uniform(*_FILLED))
    distance = float(np.clip(distance, *setting.distances))
    level = np.cos(elevation)
    towards = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    target = np.array(setting.target) + 0.1 * setting.radius * rng.uniform(-1, 1, 3)
    return azimuth, look_at(target + distance * np.array(towards), target)


def _shows(
    objects: Sequence[RigidObject],
    fixtures: Sequence[Fixture],
    intrinsics: CameraIntrinsics,
    T_world_camera: RigidTransform,
) -> bool:
    """Return whether a camera sees enough objects, and a robot arm if there is one that is free."""
    physics = FurnishedPhysics(objects, fixtures)
    for index, item in enumerate(objects):
        physics.put(index, object_pose(item))
    robot = [k for k, item in enumerate(fixtures) if item.kind == "robot"]
    if robot and physics.fixtures_touch(robot[FOOT_PARTS:], robot[:FOOT_PARTS]):
        return False
    k = reduced(intrinsics, _REDUCTION)
    pixels, parts = physics.visible_parts(k, T_world_camera)
    least = MIN_VISIBLE_SHARE * k.width * k.height
    share = parts[robot].sum() / (k.width * k.height)
    if robot and not ARM_SHARES[0] <= share <= ARM_SHARES[1]:
        return False
    seen = np.count_nonzero(pixels >= least)
    return bool(seen >= max(MIN_SEEN * len(objects), min(len(objects), 1)))

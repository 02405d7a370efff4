"""Random tabletop scenes: drawn from a seed, dropped, settled by physics, checked."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .household_shape import draw_base_shape, draw_shape
from .placement import carrier_count, place
from .tabletop_options import TabletopOptions
from .tabletop_physics import TabletopPhysics
from .tabletop_scene import Table, TabletopObject, TabletopScene, solid_volume
from .viewpoint import camera_intrinsics, draw_viewpoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scipy.spatial.transform import RigidTransform

    from eyehand.perception.superquadric import Superquadric

PALETTE = (
    (0.78, 0.30, 0.25),  # brick
    (0.20, 0.45, 0.60),  # petrol
    (0.93, 0.69, 0.28),  # amber
    (0.36, 0.56, 0.36),  # leaf
    (0.56, 0.40, 0.60),  # plum
    (0.90, 0.52, 0.40),  # coral
    (0.38, 0.68, 0.66),  # teal
    (0.88, 0.83, 0.72),  # cream
    (0.30, 0.33, 0.45),  # slate
    (0.70, 0.72, 0.40),  # olive
    (0.85, 0.55, 0.65),  # rose
    (0.55, 0.70, 0.86),  # sky
    (0.62, 0.28, 0.38),  # wine
    (0.48, 0.62, 0.30),  # moss
    (0.95, 0.78, 0.60),  # peach
)
"""Red, green, blue of objects, told apart at a glance."""


def make_scene(seed: int, options: TabletopOptions | None = None) -> TabletopScene:
    """Draw a scene whose objects stand still.

    Objects fall from `drop_height` and settle in MuJoCo. A draw is thrown away when the work
    area is too full, an object leaves its place or does not come to rest, the family's rule is
    broken in the end, or no camera sees everything; the next draw takes over. The same seed and
    options give the same scene to the last bit on one machine.

    Parameters
    ----------
    seed : int
        Source of all randomness, >= 0.
    options : TabletopOptions, optional
        What to draw from.

    Returns
    -------
    TabletopScene
        Ground truth: shapes with their poses in the world, table, camera.

    Raises
    ------
    InputError
        If the seed is not a whole number >= 0, or `tries` draws all failed (the message counts
        why).
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed!r}")
    options = options or TabletopOptions()
    faults: Counter[str] = Counter()
    for attempt in range(options.tries):
        drawn = _draw(int(seed), attempt, options)
        if isinstance(drawn, TabletopScene):
            return drawn
        faults[drawn] += 1
    told = ", ".join(f"{count}x {fault}" for fault, count in faults.most_common())
    raise InputError(
        f"no {options.family} scene of {options.count_range[0]}-{options.count_range[1]} objects "
        f"in {options.tries} tries ({told}): ask for fewer or smaller objects, a larger work_area, "
        "or more tries"
    )


def _draw(seed: int, attempt: int, options: TabletopOptions) -> TabletopScene | str:
    """One draw: a scene, or why it is none."""
    rng = np.random.default_rng([seed, attempt])
    table = Table(options.table_size, options.table_height)
    objects = _draw_objects(options, rng)
    shapes = [item.shape for item in objects]
    physics = TabletopPhysics(objects, table)
    start = place(shapes, physics, options, rng)
    if start is None:
        return "too full"
    for index, pose in enumerate(start):
        physics.put(index, pose)
    if not physics.settle(options.settle_time):
        return "never at rest"
    poses = [physics.pose(index) for index in range(len(objects))]
    fault = _fault(physics, start, poses, options)
    if fault:
        return fault
    rested = tuple(item.at(pose) for item, pose in zip(objects, poses, strict=True))
    shapes = [item.shape for item in rested]
    T_world_camera = draw_viewpoint(shapes, options.view, rng, physics.seen_pixels)
    if T_world_camera is None:
        return "no view of every object"
    intrinsics = camera_intrinsics(options.view)
    return TabletopScene(seed, options.family, rested, table, intrinsics, T_world_camera)


def _draw_objects(options: TabletopOptions, rng: np.random.Generator) -> list[TabletopObject]:
    count = int(rng.integers(options.count_range[0], options.count_range[1] + 1))
    carriers = carrier_count(count) if options.family == "stacked" else 0
    shapes = [draw_base_shape(options, rng) for _ in range(carriers)]
    for _ in range(count - carriers):
        shapes.append(draw_shape(options.kinds[rng.integers(len(options.kinds))], options, rng))
    colours = rng.permutation(len(PALETTE))
    return [
        _object(k, shape, PALETTE[colours[k % len(PALETTE)]], options, rng)
        for k, shape in enumerate(shapes)
    ]


def _object(
    index: int,
    shape: Superquadric,
    colour: tuple[float, float, float],
    options: TabletopOptions,
    rng: np.random.Generator,
) -> TabletopObject:
    mass = float(rng.uniform(*options.density_range)) * solid_volume(shape)
    return TabletopObject(f"{shape.kind}_{index + 1}", shape, mass, colour)


def _fault(
    physics: TabletopPhysics,
    start: Sequence[RigidTransform],
    poses: Sequence[RigidTransform],
    options: TabletopOptions,
) -> str:
    """Why a settled draw is no scene of its family; empty when it is one."""
    moved = [
        float(np.linalg.norm(after.translation - before.translation))
        for before, after in zip(start, poses, strict=True)
    ]
    # A NaN from a simulation that blew up must fail too.
    if not max(moved) <= options.max_drift:
        return "left its place"
    others = {k: [j for j in range(len(poses)) if j != k] for k in range(len(poses))}
    gaps = [physics.least_gap(k, rest) for k, rest in others.items()]
    if options.family == "separate" and min(gaps) < options.min_gap:
        return "closer than min_gap"
    if options.family == "touching" and max(gaps) > options.touch_gap:
        return "not touching"
    if options.family == "stacked":
        carriers = carrier_count(len(poses))
        if set(range(carriers, 2 * carriers)) & physics.on_table():
            return "not stacked"
    return ""

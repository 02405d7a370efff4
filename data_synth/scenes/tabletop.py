"""Random tabletop scenes: objects drawn from a seed, settled by physics, and checked."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception.superquadric import Superquadric

from .dropping import drop
from .household_shapes import draw_base_shape, draw_shape
from .placement import carrier_count, place
from .tabletop_options import TabletopOptions
from .tabletop_physics import TabletopPhysics
from .tabletop_scene import Table, TabletopObject, TabletopScene, solid_volume
from .viewpoint import COARSE_STEPS, FINE_STEPS, camera_intrinsics, draw_table_view, draw_viewpoint

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
"""Distinct object colours: red, green, blue."""

MAX_DRAWS = 60
"""Draws before :func:`make_scene` gives up."""
MAX_SETTLE_S = 3.0
"""Maximum simulated time to come to rest; for dropped and piled objects, after the last has
fallen."""

_STABILITY_TIME_S = 1.0
_STABILITY_DRIFT_M = 1e-4
"""Fallen objects may balance on an edge for a moment. In this time they must not move by more than
this drift."""


def make_scene(seed: int, options: TabletopOptions | None = None) -> TabletopScene:
    """Draw a scene whose objects are at rest.

    Standing objects are placed slightly above the table. Objects of the families ``dropped`` and
    ``piled`` fall one by one in any orientation. All settle in MuJoCo. A draw is rejected and
    repeated if the work area is too full, if an object leaves its place or the table or does not
    come to rest, if the family's rule is broken, or if no camera pose shows every object. The same
    seed and options give the same scene to the last bit on one machine.

    Parameters
    ----------
    seed : int
        Source of all randomness, >= 0.
    options : TabletopOptions, optional
        Numbers, sizes and arrangement of the objects.

    Returns
    -------
    TabletopScene
        Ground truth: shapes with their poses in the world, table, camera.

    Raises
    ------
    InputError
        If the seed is not a whole number >= 0, or all draws failed (the message counts the
        reasons).
    DeviceError
        If MuJoCo cannot be loaded.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed!r}")
    options = options or TabletopOptions()
    faults: Counter[str] = Counter()
    for attempt in range(MAX_DRAWS):
        drawn = _draw(int(seed), attempt, options)
        if isinstance(drawn, TabletopScene):
            return drawn
        faults[drawn] += 1
    counts = ", ".join(f"{count}x {fault}" for fault, count in faults.most_common())
    raise InputError(
        f"no {options.family} scene of {options.count_range[0]}-{options.count_range[1]} objects "
        f"in {MAX_DRAWS} draws ({counts}): ask for fewer or smaller objects, or a larger work_area"
    )


def _draw(seed: int, attempt: int, options: TabletopOptions) -> TabletopScene | str:
    """Draw once; return the scene, or the reason for its rejection."""
    rng = np.random.default_rng([seed, attempt])
    table = Table(options.table_size, options.table_height)
    intrinsics = camera_intrinsics(options.view)
    objects = _draw_objects(options, rng)
    if not objects:
        T_world_camera = draw_table_view(options, rng)
        return TabletopScene(seed, options.family, (), table, intrinsics, T_world_camera)
    falls = options.family in ("dropped", "piled")
    physics = TabletopPhysics(objects, table, no_creep=falls)
    settled = (_drop_fallen if falls else _place_standing)(objects, physics, options, rng)
    if isinstance(settled, str):
        return settled
    shapes = [item.shape for item in settled]
    steps = FINE_STEPS if falls else COARSE_STEPS
    T_world_camera = draw_viewpoint(shapes, options.view, rng, physics.visible_pixels, steps)
    if T_world_camera is None:
        return "no view of every object"
    return TabletopScene(seed, options.family, settled, table, intrinsics, T_world_camera)


def _place_standing(
    objects: list[TabletopObject],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> tuple[TabletopObject, ...] | str:
    """Place standing objects; return them at rest, or the reason for rejection."""
    start = place([item.shape for item in objects], physics, options, rng)
    if start is None:
        return "too full"
    for index, pose in enumerate(start):
        physics.put(index, pose)
    if not physics.settle(MAX_SETTLE_S):
        return "never at rest"
    settled = _settled_objects(objects, physics)
    fault = standing_fault(physics, start, [item.shape.pose for item in settled], options)
    return fault or settled


def _drop_fallen(
    objects: list[TabletopObject],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> tuple[TabletopObject, ...] | str:
    """Let objects fall one by one; return them at rest, or the reason for rejection."""
    if not drop([item.shape for item in objects], physics, options, rng):
        return "too full"
    if not physics.settle(MAX_SETTLE_S):
        return "unstable physics" if physics.unstable else "never at rest"
    settled = _settled_objects(objects, physics)
    fault = fallen_fault(physics, settled, options)
    if fault:
        return fault
    physics.run(_STABILITY_TIME_S)
    now = _settled_objects(objects, physics)
    moved = [
        float(np.linalg.norm(one.shape.centre - other.shape.centre))
        for one, other in zip(settled, now, strict=True)
    ]
    return settled if max(moved) <= _STABILITY_DRIFT_M else "balanced for a moment only"


def _settled_objects(
    objects: list[TabletopObject], physics: TabletopPhysics
) -> tuple[TabletopObject, ...]:
    return tuple(item.at(physics.pose(index)) for index, item in enumerate(objects))


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


TOUCH_GAP_M = 0.001
"""Objects no farther apart than this touch."""
MAX_DRIFT_M = 0.02
"""A scene is drawn again if a standing object moves farther than this while it settles."""
MAX_OVERLAP_M = 0.001
"""A scene is drawn again if a dropped or piled object lies deeper than this in another object or in
the table. Physics alone presses objects in by 0.02 to 0.1 mm."""
PILE_CONTACT_SHARE = 0.75
"""Minimum share of piled objects that touch another. A higher share lets fewer objects roll away
and rejects more draws."""

_LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def carried_count(count: int) -> int:
    """Return how many of `count` piled objects must lie only on others, at least."""
    return count // 4


def standing_fault(
    physics: TabletopPhysics,
    start: Sequence[RigidTransform],
    poses: Sequence[RigidTransform],
    options: TabletopOptions,
) -> str:
    """Return why standing objects break their family's rule.

    Parameters
    ----------
    physics
        The objects at rest.
    start, poses
        T_world_shape of every object, at the start and at rest.
    options
        Family ``separate``, ``touching`` or ``stacked``, and its gaps.

    Returns
    -------
    str
        The first fault; empty if there is none.
    """
    moved = [
        float(np.linalg.norm(after.translation - before.translation))
        for before, after in zip(start, poses, strict=True)
    ]
    # NaN from an unstable simulation must fail too.
    if not max(moved) <= MAX_DRIFT_M:
        return "left its place"
    gaps = _gaps(physics, len(poses))
    if options.family == "separate" and min(gaps) < options.min_gap:
        return "closer than min_gap"
    if options.family == "touching" and max(gaps) > TOUCH_GAP_M:
        return "not touching"
    if options.family == "stacked":
        carriers = carrier_count(len(poses))
        if set(range(carriers, 2 * carriers)) & physics.on_table():
            return "not stacked"
    return ""


def fallen_fault(
    physics: TabletopPhysics, objects: Sequence[TabletopObject], options: TabletopOptions
) -> str:
    """Return why fallen objects break their family's rule.

    All must lie over the table and overlap by at most `MAX_OVERLAP_M`. All dropped objects must
    touch the table. Of the piled objects, the share `PILE_CONTACT_SHARE` must touch another, and
    `carried_count` must lie only on others.

    Parameters
    ----------
    physics
        The objects at rest.
    objects
        The same objects, with their poses at rest.
    options
        Family ``dropped`` or ``piled``, and the table.

    Returns
    -------
    str
        The first fault; empty if there is none.
    """
    half = np.tile(np.array(options.table_size) / 2, 2)
    if not all(np.all(item.shape.support(_LEVEL) <= half) for item in objects):
        return "off the table"
    if not physics.max_penetration() <= MAX_OVERLAP_M:
        return "overlap"
    count = len(objects)
    carried = count - len(physics.on_table())
    if options.family == "dropped":
        return "on top of another" if carried else ""
    touching = sum(gap <= TOUCH_GAP_M for gap in _gaps(physics, count))
    if touching < PILE_CONTACT_SHARE * count:
        return "scattered"
    return "no pile" if carried < carried_count(count) else ""


def _gaps(physics: TabletopPhysics, count: int) -> list[float]:
    """Return the distance from each object to the nearest other one, m."""
    return [physics.nearest_gap(k, [j for j in range(count) if j != k]) for k in range(count)]

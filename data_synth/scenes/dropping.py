"""Objects that fall one by one in any orientation, apart from each other or into a pile."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception.superquadric import Superquadric

from .placement import FALL_HEIGHT_M, place, tumbled
from .tabletop_options import TabletopOptions
from .tabletop_physics import TabletopPhysics

_PAUSE_S = 0.6
"""Maximum time before the next object falls: most lie still by then."""
_BOWL_PULL_M_S2 = 4.0
"""Horizontal acceleration towards the middle while a pile forms, as in a bowl with walls of 22°. On
a flat table, round objects and those that slide off others end up apart. A steeper bowl packs them
so tightly that they fly apart when it is removed."""
_BOWL_FADES_S = 0.3
_BOWL_FADE_STEPS = 10
"""The bowl becomes flat slowly enough for friction to hold the pile."""
_TOUCH_M = 0.001
"""Gap at which a lowered object touches what lies below it."""
_LOWERING_STEPS = 60


def drop(
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> bool:
    """Let objects fall one after the other, each from `FALL_HEIGHT_M` above what lies below it.

    They may still move slightly at the end.

    Parameters
    ----------
    shapes
        The solids, shape frames at the origin.
    physics
        The simulation; its objects end on the table.
    options
        Family (``dropped`` or ``piled``), area and heights.
    rng
        Source of randomness.

    Returns
    -------
    bool
        False if the work area is too full for objects that must fall apart from each other.
    """
    physics.park(range(len(shapes)))
    if options.family == "piled":
        _heap(shapes, physics, options, rng)
        return True
    starts = place(shapes, physics, options, rng)
    if starts is None:
        return False
    for index, start in enumerate(starts):
        _drop_one(index, start, shapes, physics, options)
    return True


def _heap(
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> None:
    """Drop objects onto a small disc in a shallow bowl, then flatten the bowl."""
    # Lying flat, an object covers about the product of its two longer extents.
    covered = sum(4 * float(np.prod(np.sort(shape.semi_axes)[1:])) for shape in shapes)
    radius = np.sqrt(covered / np.pi)
    physics.bowl(radius, _BOWL_PULL_M_S2)
    for index, shape in enumerate(shapes):
        away = options.pile_spread * radius * np.sqrt(rng.uniform())
        angle = rng.uniform(0, 2 * np.pi)
        spot = [away * np.cos(angle), away * np.sin(angle), options.table_height]
        start = RigidTransform.from_translation(spot) * tumbled(shape, FALL_HEIGHT_M, rng)
        _drop_one(index, start, shapes, physics, options)
    for share in np.linspace(1.0, 0.0, _BOWL_FADE_STEPS + 1)[1:]:
        physics.bowl(radius, share * _BOWL_PULL_M_S2)
        physics.run(_BOWL_FADES_S / _BOWL_FADE_STEPS)


def _drop_one(
    index: int,
    start: RigidTransform,
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
) -> None:
    """Lower an object onto what lies below it, lift it by `FALL_HEIGHT_M`, and let it fall.

    Moving down by the smallest gap cannot cause overlap (conservative advancement, Mirtich 1996).
    """
    below = range(index)
    reach = np.linalg.norm(shapes[index].semi_axes)
    tops = [
        physics.pose(k).translation[2] + np.linalg.norm(shapes[k].semi_axes) + reach for k in below
    ]
    floor = start.translation[2] - FALL_HEIGHT_M
    position = np.array(start.translation)
    position[2] = max([floor, *tops])
    physics.put(index, RigidTransform.from_components(position, start.rotation))
    for _ in range(_LOWERING_STEPS):
        gap = min(physics.nearest_gap(index, below), position[2] - floor)
        if gap < _TOUCH_M:
            break
        position[2] -= gap
        physics.move(index, position)
    position[2] += FALL_HEIGHT_M
    physics.move(index, position)
    physics.settle(_PAUSE_S)

"""Checks that objects at rest follow the rule of their family."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import RigidTransform

from .placement import carrier_count
from .tabletop_options import TabletopOptions
from .tabletop_physics import TabletopPhysics
from .tabletop_scene import TabletopObject

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

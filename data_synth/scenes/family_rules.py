"""Whether objects that have come to rest stand to one another as their family says."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .placement import carrier_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scipy.spatial.transform import RigidTransform

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
"""Smallest share of piled objects that touch another. A higher share lets fewer objects roll away
and rejects more draws."""

_LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


def carried_count(count: int) -> int:
    """How many of `count` piled objects must lie on others only, at least."""
    return count // 4


def standing_fault(
    physics: TabletopPhysics,
    start: Sequence[RigidTransform],
    poses: Sequence[RigidTransform],
    options: TabletopOptions,
) -> str:
    """Why objects put down at `start` and at rest at `poses` break their family's rule.

    Parameters
    ----------
    physics
        Their state at rest.
    start, poses
        T_world_shape of every object, before and after.
    options
        Family ``separate``, ``touching`` or ``stacked``, and its lengths.

    Returns
    -------
    str
        The first fault found; empty when there is none.
    """
    moved = [
        float(np.linalg.norm(after.translation - before.translation))
        for before, after in zip(start, poses, strict=True)
    ]
    # A NaN from a simulation that blew up must fail too.
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
    """Why objects that fell and came to rest break their family's rule.

    All lie over the table, and none deeper in another than `max_overlap`. Dropped objects all
    touch the table. Of piled ones, `pile_contact` touch another, and `carried_count` lie on
    others only.

    Parameters
    ----------
    physics
        Their state at rest.
    objects
        The same objects, where they came to rest.
    options
        Family ``dropped`` or ``piled``, and its lengths.

    Returns
    -------
    str
        The first fault found; empty when there is none.
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
    """Distance from each object to the nearest other, m."""
    return [physics.nearest_gap(k, [j for j in range(count) if j != k]) for k in range(count)]

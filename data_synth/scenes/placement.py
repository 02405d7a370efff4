"""Initial poses of objects, before physics settles them, for each family of scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.superquadric import Superquadric

from .household_shapes import rest_rotation
from .tabletop_options import TabletopOptions
from .tabletop_physics import TabletopPhysics

FALL_HEIGHT_M = 0.03
"""Dropped and piled objects fall from this height above what lies below them. With a higher
fall they scatter more and settle later, and more draws are rejected."""

_RELEASE_HEIGHT_M = 0.002
"""Standing objects are released at this height. A larger height would move them, and more draws
would be rejected."""
_RELEASE_TILT_RAD = 0.03
"""Maximum tilt at the start. It makes an object that balances on an edge fall over, and the draw is
rejected. Touching objects start level."""
_MIN_GROUP_SIZE = 4
"""Minimum number of objects in a touching group. A smaller scene is one group."""
_ANGLES = np.arange(96) / 96 * 2 * np.pi
_DIRECTIONS = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES), np.zeros_like(_ANGLES)])
_SPOTS = 300
"""Random positions tried at once for one group."""
_LAYOUTS = 12
"""Layouts of all objects tried before the draw is rejected."""
_GAP_SLACK_M = 0.002
"""Objects start this much farther apart than they must be at rest."""
_CONTACT_M = 1e-4
"""Gap between touching objects before they settle."""
_APPROACHES = 24
"""Maximum number of directions from which an object is moved towards the previous ones."""
_APPROACH_START_M = 0.8
"""Distance from the goal at the start of an approach."""
_APPROACH_STEPS = 60
"""Maximum number of steps of an approach."""
_TOP_OFFSET_SHARE = 0.3
"""A carried object's centre lies within this share of its carrier's half-width."""


@dataclass
class _Group:
    """Objects that are placed together, with their poses relative to the group."""

    members: list[int]
    places: list[RigidTransform]


def carrier_count(count: int) -> int:
    """Return how many of `count` stacked objects carry another.

    With n carriers, object k < n carries object n + k. The other objects stand alone.
    """
    return (count + 1) // 3


def place(
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> list[RigidTransform] | None:
    """Find a pose for every object, slightly above the surface on which it will rest.

    Objects of the family ``dropped`` get any orientation, `FALL_HEIGHT_M` above the table.

    Parameters
    ----------
    shapes
        The solids. In the family ``stacked``, the first `carrier_count` must be flat-topped.
    physics
        Used to measure distances. The poses of its objects are undefined afterwards.
    options
        Family, area and gaps.
    rng
        Source of randomness.

    Returns
    -------
    list of RigidTransform, or None
        T_world_shape of every object, or None if no layout was found.
    """
    for _ in range(_LAYOUTS):
        groups = _groups(shapes, physics, options, rng)
        spots = None if groups is None else _pack(groups, shapes, options, rng)
        if groups is not None and spots is not None:
            placed = {
                member: RigidTransform.from_translation([*spot, options.table_height]) * local
                for group, spot in zip(groups, spots, strict=True)
                for member, local in zip(group.members, group.places, strict=True)
            }
            return [placed[k] for k in range(len(shapes))]
    return None


def tumbled(shape: Superquadric, height: float, rng: np.random.Generator) -> RigidTransform:
    """Draw a pose over the origin in any orientation, with the lowest point at `height`, m."""
    return _lifted(shape, height, Rotation.random(rng=rng))


def _groups(
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> list[_Group] | None:
    count = len(shapes)
    if options.family == "touching":
        group_count = max(count // _MIN_GROUP_SIZE, 1)
        parts = np.array_split(np.arange(count), group_count)
        groups = [_touching(part.tolist(), shapes, physics, options, rng) for part in parts]
        whole = [group for group in groups if group is not None]
        return whole if len(whole) == len(groups) else None
    carriers = carrier_count(count) if options.family == "stacked" else 0
    stacks = [_stack(k, k + carriers, shapes, options, rng) for k in range(carriers)]
    return stacks + [_single(k, shapes, options, rng) for k in range(2 * carriers, count)]


def _single(
    index: int,
    shapes: Sequence[Superquadric],
    options: TabletopOptions,
    rng: np.random.Generator,
) -> _Group:
    if options.family == "dropped":
        return _Group([index], [tumbled(shapes[index], FALL_HEIGHT_M, rng)])
    return _Group([index], [_resting(shapes[index], _RELEASE_HEIGHT_M, _RELEASE_TILT_RAD, rng)])


def _resting(
    shape: Superquadric,
    height: float,
    tilt: float,
    rng: np.random.Generator,
    *,
    upright: bool = False,
) -> RigidTransform:
    """Draw a pose at the origin, tilted by up to `tilt` rad, the lowest point at `height`, m."""
    angle = rng.uniform(0, 2 * np.pi)
    lean = tilt * np.sqrt(rng.uniform()) * np.array([np.cos(angle), np.sin(angle), 0.0])
    rotation = Rotation.from_rotvec(lean) * rest_rotation(shape, rng, upright=upright)
    return _lifted(shape, height, rotation)


def _lifted(shape: Superquadric, height: float, rotation: Rotation) -> RigidTransform:
    depth = shape.support(rotation.inv().apply([0.0, 0.0, -1.0]))
    return RigidTransform.from_components([0.0, 0.0, height + float(depth)], rotation)


def _stack(
    carrier: int,
    carried: int,
    shapes: Sequence[Superquadric],
    options: TabletopOptions,
    rng: np.random.Generator,
) -> _Group:
    base = shapes[carrier]
    below = _resting(base, _RELEASE_HEIGHT_M, _RELEASE_TILT_RAD, rng, upright=True)
    # The highest point of a tilted carrier, so that the carried object does not start inside.
    top = float(base.support(below.rotation.inv().apply([0.0, 0.0, 1.0]))) + below.translation[2]
    above = _resting(shapes[carried], top + _RELEASE_HEIGHT_M, _RELEASE_TILT_RAD, rng)
    reach = _TOP_OFFSET_SHARE * base.semi_axes[:2].min() * np.sqrt(rng.uniform())
    angle = rng.uniform(0, 2 * np.pi)
    aside = RigidTransform.from_translation([reach * np.cos(angle), reach * np.sin(angle), 0.0])
    return _Group([carrier, carried], [below, aside * above])


def _touching(
    members: Sequence[int],
    shapes: Sequence[Superquadric],
    physics: TabletopPhysics,
    options: TabletopOptions,
    rng: np.random.Generator,
) -> _Group | None:
    """Move each object towards the previous ones until it almost touches one of them."""
    physics.park(range(len(shapes)))
    lift = RigidTransform.from_translation([0.0, 0.0, options.table_height])
    group = _Group([], [])
    for index in members:
        # The object starts level. A tilted one rocks and moves away from the one it touched.
        resting = _resting(shapes[index], _RELEASE_HEIGHT_M, 0.0, rng)
        place = resting if not group.members else None
        for _ in range(_APPROACHES):
            if place is not None:
                break
            goal = group.places[rng.integers(len(group.places))].translation
            angle = rng.uniform(0, 2 * np.pi)
            heading = np.array([np.cos(angle), np.sin(angle), 0.0])
            place = _approach(index, resting, goal, heading, group.members, physics, lift)
        if place is None:
            return None
        physics.put(index, lift * place)
        group.members.append(int(index))
        group.places.append(place)
    return group


def _approach(
    index: int,
    resting: RigidTransform,
    goal: NDArray[np.float64],
    heading: NDArray[np.float64],
    others: Sequence[int],
    physics: TabletopPhysics,
    lift: RigidTransform,
) -> RigidTransform | None:
    """Slide an object over the table along `heading`, towards the vertical axis through `goal`.

    Each step is as long as the gap to the nearest of the other objects. Moving by the gap cannot
    cause overlap (conservative advancement, Mirtich 1996). Return the pose close to contact, or
    None if the object passes the axis or is still too far away after `_APPROACH_STEPS`.
    """
    physics.put(index, lift * resting)
    target = np.array([goal[0], goal[1], resting.translation[2]])
    away = _APPROACH_START_M
    for _ in range(_APPROACH_STEPS):
        position = target - away * heading
        physics.move(index, lift.translation + position)
        gap = physics.nearest_gap(index, others)
        if gap < 2 * _CONTACT_M:
            return RigidTransform.from_components(position, resting.rotation) if gap > 0 else None
        away -= gap - _CONTACT_M
        if away < 0:
            return None
    return None


def _pack(
    groups: Sequence[_Group],
    shapes: Sequence[Superquadric],
    options: TabletopOptions,
    rng: np.random.Generator,
) -> list[NDArray[np.float64]] | None:
    """Find positions (2,) of groups, m, so that their members are `min_gap` apart seen from above.

    Two convex outlines are `min_gap` apart if their support functions leave this gap along some
    direction.
    """
    outlines = [_outlines(group, shapes) for group in groups]
    half = np.array(options.work_area) / 2
    gap = options.min_gap + _GAP_SLACK_M
    spots: dict[int, NDArray[np.float64]] = {}
    # Place the largest group first, because small ones fit between.
    for k in sorted(range(len(groups)), key=lambda k: -float(outlines[k].max())):
        # An outline reaches h(d) in direction d; the position keeps it inside the work area.
        right, up, left, down = outlines[k].max(axis=0)[:: len(_ANGLES) // 4]
        low, high = -half + [left, down], half - [right, up]
        if np.any(low > high):
            return None
        tried = rng.uniform(low, high, size=(_SPOTS, 2))
        for other, spot in spots.items():
            along = (spot - tried) @ _DIRECTIONS[:, :2].T
            for mine in outlines[k]:
                for theirs in outlines[other]:
                    between = along - mine - np.roll(theirs, len(_ANGLES) // 2)
                    keep = between.max(axis=1) >= gap
                    tried, along = tried[keep], along[keep]
        if len(tried) == 0:
            return None
        spots[k] = tried[0]
    return [spots[k] for k in range(len(groups))]


def _outlines(group: _Group, shapes: Sequence[Superquadric]) -> NDArray[np.float64]:
    """Compute support functions of the members in horizontal directions, (members, 96), m."""
    supports = [
        shapes[member].support(local.rotation.inv().apply(_DIRECTIONS))
        + _DIRECTIONS @ local.translation
        for member, local in zip(group.members, group.places, strict=True)
    ]
    return np.array(supports)

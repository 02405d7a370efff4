"""Plan the place and the pose of a held object in the tray.

The camera does not see the tray's content, so that its model is what was put there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import Cylinder, Obstacle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .tray import Tray

UP = np.array([0.0, 0.0, 1.0])
WALL_DISTANCE = 0.055
"""Minimum distance of a place from the walls for a hand with fingers, m. The hand must fit between
object and wall."""
JAW_DEPTH = 0.025
"""Depth of a jaw behind its pad, m. Jaws that open must not reach the wall."""
GRID_STEP = 0.010
"""Distance of the places that are tried, m."""
FREE_GAP = 0.020
"""Gap to the content above which more has no effect, m. Fingers that open need it."""
MAX_OVERLAP = 0.005
"""Overlap of an object with the disc of another up to which it stands beside it, m. Most objects
cover less than their disc. On another object it would topple, perhaps over the wall."""
UNSTABLE_RATIO = 2.2
"""Ratio of height to narrowest width above which an upright object may topple in the tray: the hand
that opens, or the next object, pushes it."""
SIDE_COSINE = 0.5
"""Maximum cosine between palm and down of a grasp that counts as one from the side."""
DIRECTIONS = 16
"""Number of horizontal directions over half a turn in which an object is measured."""


@dataclass(frozen=True, eq=False)
class TrayItem:
    """A disc that an object in the tray may cover."""

    place: NDArray[np.float64]
    """Centre, (2,), world, m."""
    radius: float
    """Radius, m."""
    top: float
    """Height of the object there above the tray's floor, m."""
    stands: bool = True
    """Whether the object is there. Otherwise it is there only if it fell."""


@dataclass(frozen=True)
class HeldSize:
    """Size of a held object in the pose in which it is put down."""

    radius: float
    """Maximum horizontal distance of its surface from its centre, m."""
    narrowest: float
    """Minimum horizontal width, m."""
    below: float
    """Distance of its lowest point below its centre, m."""
    height: float
    """Height, m."""

    @property
    def unstable(self) -> bool:
        """Whether it may topple after the release."""
        return self.height > UNSTABLE_RATIO * self.narrowest


class TrayPlace(NamedTuple):
    """A place in the tray."""

    position: NDArray[np.float64]
    """Position on the floor, (3,), world, m."""
    below: float
    """Height of the content under the object, m."""
    gap: float
    """Distance of the object's disc from that of the nearest content that reaches above its lower
    end, m; at most `FREE_GAP`."""


def measure_held(parts: Sequence[Superquadric], centre: NDArray[np.float64]) -> HeldSize:
    """Return the size of solids that stay upright; ``centre`` (3,) is that of the object, m."""
    angles = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    across = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)])
    directions = np.vstack([across, -across, UP, -UP])
    ends = np.max([part.support(directions) for part in parts], axis=0) - directions @ centre
    widths = ends[:DIRECTIONS] + ends[DIRECTIONS:-2]
    return HeldSize(
        float(ends[:-2].max()), float(widths.min()), float(ends[-1]), float(ends[-2] + ends[-1])
    )


def laid_size(upright: HeldSize, thickness: float) -> HeldSize:
    """Return the size of an upright object after it is laid down; its thickness is then up."""
    reach = max(upright.below, upright.height - upright.below, upright.radius)
    return HeldSize(reach, thickness, 0.5 * thickness, thickness)


def plan_place(
    tray: Tray, content: Sequence[TrayItem], size: HeldSize, wall_distance: float = WALL_DISTANCE
) -> TrayPlace:
    """Return the lowest place for an object, free of the content if there is room.

    An object that may topple goes so far from the walls that it falls into the tray. Others fill
    the tray from its corners.
    """
    positions, below, gap = measure_places(tray, content, size, wall_distance)
    corner = -np.abs(positions[:, :2] - tray.centre[:2]).sum(axis=1)
    best = np.lexsort((corner, -gap.round(3), below.round(3)))[0]
    return TrayPlace(positions[best], float(below[best]), float(gap[best]))


def measure_places(
    tray: Tray, content: Sequence[TrayItem], size: HeldSize, wall_distance: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the fields of `TrayPlace` for all places of an object, (G, 3), (G,) and (G,)."""
    half = 0.5 * np.asarray(tray.size)
    # The centre of an object that topples comes to rest half its height beside its place.
    reach = max(size.radius, 0.5 * size.height if size.unstable else 0.0, wall_distance)
    ends = np.maximum(half - reach, 0.0)
    x, y = (np.linspace(-end, end, 2 * int(end / GRID_STEP) + 1) for end in ends)
    grid = np.array(np.meshgrid(x, y, indexing="ij")).reshape(2, -1).T
    tops = np.array([item.top for item in content])
    apart = np.array(
        [np.linalg.norm(grid + tray.centre[:2] - item.place, axis=1) for item in content]
    ).reshape(len(content), len(grid))
    apart -= size.radius + np.array([[item.radius] for item in content]).reshape(-1, 1)
    below = np.where(apart < -MAX_OVERLAP, tops[:, None], 0.0).max(axis=0, initial=0.0)
    # What a tall object covers if it fell is under every place. It must not hide what stands there.
    gap = np.where(tops[:, None] > below, apart, FREE_GAP).min(axis=0, initial=FREE_GAP)
    return tray.centre + np.column_stack([grid, np.zeros(len(grid))]), below, gap


def added_items(size: HeldSize, centre: NDArray[np.float64], below: float) -> tuple[TrayItem, ...]:
    """Return what an object adds to the content: where it is, and where it may have fallen.

    It was released with its centre at (3,), world, above content of a height ``below``, m. A finger
    near a wall may have kept it from its planned place.
    """
    standing = TrayItem(centre[:2], size.radius, below + size.height)
    if not size.unstable:
        return (standing,)
    return standing, TrayItem(centre[:2], size.height, below + size.narrowest, stands=False)


def content_obstacles(tray: Tray, content: Sequence[TrayItem]) -> tuple[Obstacle, ...]:
    """Return the objects that stand in the tray as obstacles of a hand that reaches into it."""
    return tuple(
        Obstacle(
            f"content {number}",
            Cylinder(max(item.radius - MAX_OVERLAP, MAX_OVERLAP), 0.5 * item.top),
            RigidTransform.from_translation(np.append(item.place, tray.centre[2] + 0.5 * item.top)),
        )
        for number, item in enumerate(content)
        if item.stands
    )

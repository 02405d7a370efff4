"""The inputs of the distance kernels: views of MuJoCo's buffers and tables by geom and pair."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .mujoco_binding import Data, Model, address

KIND, BOUND, MIDDLE, HALF, SIZE = 0, 1, 2, 5, 8
"""Columns of :attr:`ProximityTables.shapes`."""
FULL_SCALE = 1000
"""Scale of a distance that is not changed, in :attr:`ProximityTables.pairs`."""
HELD_GEOM, HELD_BODY, HELD_POSITION, HELD_AXES = 0, 1, 2, 5
"""Columns of :attr:`ProximityTables.held`."""


@dataclass(frozen=True, eq=False)
class ProximityTables:
    """Tables of one world. Those by geom are changed in place when an obstacle moves."""

    model: Model
    """The compiled ``MjModel``."""
    data: Data
    """Its ``MjData``, whose buffers every computation overwrites."""
    joints: NDArray[np.int64]
    """(n, 3): index in ``qpos``, id, 1 for a hinge and 0 for a slide joint."""
    moves: NDArray[np.bool_]
    """(geoms, n): whether a joint moves a geom."""
    shapes: NDArray[np.float64]
    """(geoms, 11): MuJoCo's type, bounding radius, centre and half extents of the bounding box in
    the geom's frame, size."""
    motion: NDArray[np.float64]
    """(geoms, 9): origin of an obstacle, its linear velocity there and its angular velocity,
    world."""
    pairs: NDArray[np.int64]
    """(pairs, 3): the two geoms, that of the robot first, and the scale of their distance in
    thousandths, see `collision_pairs.sort_pairs`."""
    names: tuple[tuple[str, str], ...]
    """Names of the pairs."""
    held: NDArray[np.float64]
    """(held objects, 14): geom, the body that holds it, origin and axes of the geom in this
    body."""
    cut_off: float
    """Distance beyond which pairs are skipped, m."""

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """Names of the pairs as one text each."""
        return tuple(f"{first} near {second}" for first, second in self.names)


class World(NamedTuple):
    """The inputs for the distance of two geoms, for kernels."""

    model: int
    """Address of the ``MjModel``."""
    data: int
    """Address of the ``MjData``."""
    positions: NDArray[np.float64]
    """``geom_xpos`` (geoms, 3), m."""
    matrices: NDArray[np.float64]
    """``geom_xmat`` (geoms, 9)."""
    shapes: NDArray[np.float64]
    """:attr:`ProximityTables.shapes`."""
    cut_off: float
    """:attr:`ProximityTables.cut_off`, m."""


@njit(cache=True)
def nearer(world, cut_off):
    """Return a :class:`World` with another cut-off distance, m."""
    return World(
        world.model, world.data, world.positions, world.matrices, world.shapes, cut_off,
    )  # fmt: skip


def shape_row(model: Model, geom: int) -> NDArray[np.float64]:
    """Return a row of :attr:`ProximityTables.shapes` for a geom as it is in the model now."""
    kind, bound = model.geom_type[geom], model.geom_rbound[geom]
    return np.array([kind, bound, *model.geom_aabb[geom], *model.geom_size[geom]], dtype=np.float64)


def kernel_arguments(tables: ProximityTables) -> tuple:
    """Return addresses, views and tables in the order of the kernel's arguments after ``q``."""
    model, data = tables.model, tables.data
    views = (data.qpos, data.xanchor, data.xaxis, data.xpos, data.xmat)
    geoms = (data.geom_xpos, data.geom_xmat)
    pairs = (tables.joints, tables.moves, tables.shapes, tables.motion, tables.pairs)
    return (address(model), address(data), *views, *geoms, *pairs, tables.held, tables.cut_off)

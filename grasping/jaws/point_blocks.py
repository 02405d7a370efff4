"""Points of the scene in small blocks: a candidate is compared with the blocks near it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

BLOCK = 0.02
"""Side of a block, m: about the width of a finger."""
_BITS = 16
"""Bits of the index of a block along each axis: 1.3 km."""

_Parts = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]
Columns = tuple[NDArray[np.float64], _Parts, _Parts]
"""Points and spheres as arrays with a row for each coordinate."""


@dataclass(frozen=True, eq=False)
class Spheres:
    """Spheres around consecutive parts of an array."""

    start: NDArray[np.int64]
    """Index of the first element of each part and the number of elements at the end, (n + 1,)."""
    centre: NDArray[np.float64]
    """Centre of the bounding box of each part, (n, 3), m."""
    radius: NDArray[np.float64]
    """Distance of its corners from it, (n,), m."""


@dataclass(frozen=True, eq=False)
class PointBlocks:
    """Points sorted into groups, and each group into blocks."""

    points: NDArray[np.float64]
    """Points in the order of the blocks, (N, 3), m."""
    blocks: Spheres
    """Spheres of the blocks around the points."""
    groups: Spheres
    """Spheres of the groups; `start` counts blocks."""
    label: NDArray[np.int64]
    """Object of each group, (G,); -1 for none."""
    order: NDArray[np.int64]
    """Index of each point in the joined groups, (N,)."""

    @cached_property
    def columns(self) -> Columns:
        """Points (3, N), and start, centre (3, n) and radius of blocks and of groups."""
        return (
            np.ascontiguousarray(self.points.T),
            (self.blocks.start, np.ascontiguousarray(self.blocks.centre.T), self.blocks.radius),
            (self.groups.start, np.ascontiguousarray(self.groups.centre.T), self.groups.radius),
        )


def point_blocks(
    groups: Sequence[NDArray[np.float64]], labels: Sequence[int], side: float = BLOCK
) -> PointBlocks:
    """Sort groups of points (n, 3) into blocks. The groups have the given labels."""
    filled = [(group, label) for group, label in zip(groups, labels, strict=True) if len(group)]
    if not filled:
        none = Spheres(np.zeros(1, np.int64), np.zeros((0, 3)), np.zeros(0))
        empty = np.zeros(0, np.int64)
        return PointBlocks(np.zeros((0, 3)), none, none, empty, empty)
    cloud = np.concatenate([group for group, _ in filled]).astype(np.float64, copy=False)
    count = np.array([len(group) for group, _ in filled])
    group = np.repeat(np.arange(len(count)), count)
    cell = np.floor((cloud - cloud.min(axis=0)) / side).astype(np.int64)
    key = ((group << _BITS | cell[:, 0]) << _BITS | cell[:, 1]) << _BITS | cell[:, 2]
    order = np.argsort(key)
    key, cloud = key[order], np.ascontiguousarray(cloud[order])
    of_blocks = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    of_groups = np.append(0, np.cumsum(count)[:-1])
    blocks, whole = _spheres(cloud, of_blocks), _spheres(cloud, of_groups)
    first = np.searchsorted(blocks.start, whole.start)
    return PointBlocks(
        points=cloud,
        blocks=blocks,
        groups=Spheres(first, whole.centre, whole.radius),
        label=np.array([label for _, label in filled], np.int64),
        order=order,
    )


def _spheres(cloud: NDArray[np.float64], first: NDArray[np.int64]) -> Spheres:
    """Return spheres around the parts of a cloud that begin at the given places."""
    low = np.minimum.reduceat(cloud, first, axis=0)
    high = np.maximum.reduceat(cloud, first, axis=0)
    radius = 0.5 * np.linalg.norm(high - low, axis=1)
    return Spheres(np.append(first, len(cloud)), 0.5 * (low + high), radius)

"""Proposals to split a cloud in two: by planes, by clustering, and by what a solid misses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

PLANE_POSITIONS = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Positions of splitting planes, as shares of the extent of the cloud."""
LLOYD_ROUNDS = 8
"""Maximum rounds of two-means clustering."""
MISSED_NOISE = 2.0
"""A solid misses points farther away than so many times the noise."""


def propose_splits(
    points: NDArray[np.float64],
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    rotation: NDArray[np.float64],
    noise: float,
    min_points: int,
) -> list[NDArray[np.bool_]]:
    """Propose splits of a cloud as masks (N,) of the second part, without duplicates.

    Parameters
    ----------
    points
        (N, 3), m.
    neighbours
        (N, K) indices of the neighbours of each point, -1 for neighbours outside the cloud.
    residuals
        (N,) signed distances from the solid that is to be split, m.
    rotation
        Its axes as columns, (3, 3). Planes split across these and the principal axes.
    noise
        Expected noise of the points, one standard deviation, m.
    min_points
        Minimum number of points on either side.
    """
    splits: list[NDArray[np.bool_]] = []
    for mask in _all_splits(points, neighbours, residuals, rotation, noise):
        count = int(np.count_nonzero(mask))
        if min(count, len(mask) - count) < min_points:
            continue
        if all(_difference(mask, other) > min_points // 2 for other in splits):
            splits.append(mask)
    return splits


def largest_cluster(mask: NDArray[np.bool_], neighbours: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return the largest connected group of the points in a mask (N,), by neighbours (N, K)."""
    cluster = np.zeros(len(mask), dtype=bool)
    index = np.flatnonzero(mask)
    if len(index) == 0:
        return cluster
    position = np.full(len(mask) + 1, -1)
    position[index] = np.arange(len(index))
    ends = position[neighbours[index]]
    starts = np.broadcast_to(np.arange(len(index))[:, None], ends.shape)
    linked = ends >= 0
    links = (np.ones(np.count_nonzero(linked)), (starts[linked], ends[linked]))
    _, group = connected_components(csr_matrix(links, shape=(len(index),) * 2), directed=False)
    cluster[index[group == np.argmax(np.bincount(group))]] = True
    return cluster


def _all_splits(
    points: NDArray[np.float64],
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    rotation: NDArray[np.float64],
    noise: float,
) -> Iterator[NDArray[np.bool_]]:
    for missed in (residuals > MISSED_NOISE * noise, residuals < -MISSED_NOISE * noise):
        yield largest_cluster(missed, neighbours)
    centred = points - points.mean(axis=0)
    _, sizes, rows = np.linalg.svd(centred, full_matrices=False)
    for axis in (*rows, *rotation.T):
        along = centred @ axis
        low, high = along.min(), along.max()
        for position in PLANE_POSITIONS:
            yield along > low + position * (high - low)
    principal = centred @ rows.T
    for scaled in (principal, principal / np.maximum(sizes, 1e-12 * sizes[0])):
        for column in range(2):
            yield _two_means(scaled, scaled[:, column] > 0.0)


def _two_means(points: NDArray[np.float64], second: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Run Lloyd's algorithm for two clusters from a first split (N,)."""
    for _ in range(LLOYD_ROUNDS):
        if second.all() or not second.any():
            break
        one, other = points[~second].mean(axis=0), points[second].mean(axis=0)
        update = (points - 0.5 * (one + other)) @ (other - one) > 0.0
        if np.array_equal(update, second):
            break
        second = update
    return second


def _difference(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> int:
    """Return how many points two splits divide differently, in either order of the sides."""
    differing = int(np.count_nonzero(one ^ other))
    return min(differing, len(one) - differing)

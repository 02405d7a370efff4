"""Ways to cut a cloud in two: by planes across its axes, by nearness, by what a solid misses."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

PLACES = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Where planes cut, as shares of the cloud's extent."""
LLOYD_ROUNDS = 8
"""Most rounds of two-means."""
MISSED = 2.0
"""Points farther from a solid than so many times the noise are missed by it."""


def cuts(
    points: NDArray[np.float64],
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    rotation: NDArray[np.float64],
    noise: float,
    fewest: int,
) -> list[NDArray[np.bool_]]:
    """Propose second parts of a cloud, as masks (N,), each once.

    Parameters
    ----------
    points
        (N, 3), m.
    neighbours
        (N, K) indices of each point's neighbours, -1 for those that lie elsewhere.
    residuals
        (N,) signed distances from the solid that is to be split, m.
    rotation
        Its axes as columns, (3, 3); planes cut across these and the cloud's principal axes.
    noise
        Expected noise of the points, one σ, m.
    fewest
        Points that either side must have.
    """
    found: list[NDArray[np.bool_]] = []
    for mask in _proposals(points, neighbours, residuals, rotation, noise):
        count = int(np.count_nonzero(mask))
        if min(count, len(mask) - count) < fewest:
            continue
        if all(_difference(mask, other) > fewest // 2 for other in found):
            found.append(mask)
    return found


def largest_cluster(chosen: NDArray[np.bool_], neighbours: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Largest group of chosen points (N,) that hang together by neighbours (N, K)."""
    cluster = np.zeros(len(chosen), dtype=bool)
    index = np.flatnonzero(chosen)
    if len(index) == 0:
        return cluster
    place = np.full(len(chosen) + 1, -1)
    place[index] = np.arange(len(index))
    ends = place[neighbours[index]]
    starts = np.broadcast_to(np.arange(len(index))[:, None], ends.shape)
    linked = ends >= 0
    links = (np.ones(np.count_nonzero(linked)), (starts[linked], ends[linked]))
    _, group = connected_components(csr_matrix(links, shape=(len(index),) * 2), directed=False)
    cluster[index[group == np.argmax(np.bincount(group))]] = True
    return cluster


def _proposals(
    points: NDArray[np.float64],
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    rotation: NDArray[np.float64],
    noise: float,
) -> Iterator[NDArray[np.bool_]]:
    for missed in (residuals > MISSED * noise, residuals < -MISSED * noise):
        yield largest_cluster(missed, neighbours)
    centred = points - points.mean(axis=0)
    _, sizes, rows = np.linalg.svd(centred, full_matrices=False)
    for axis in (*rows, *rotation.T):
        along = centred @ axis
        low, high = along.min(), along.max()
        for place in PLACES:
            yield along > low + place * (high - low)
    own = centred @ rows.T
    for image in (own, own / np.maximum(sizes, 1e-12 * sizes[0])):
        for column in range(2):
            yield _two_means(image, image[:, column] > 0.0)


def _two_means(points: NDArray[np.float64], second: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Lloyd's algorithm from a first division (N,)."""
    for _ in range(LLOYD_ROUNDS):
        if second.all() or not second.any():
            break
        one, other = points[~second].mean(axis=0), points[second].mean(axis=0)
        moved = (points - 0.5 * (one + other)) @ (other - one) > 0.0
        if np.array_equal(moved, second):
            break
        second = moved
    return second


def _difference(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> int:
    """Points that two cuts divide differently, whichever side is called the second."""
    apart = int(np.count_nonzero(one ^ other))
    return min(apart, len(one) - apart)

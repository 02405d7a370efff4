"""Proposals to cut a cloud in two: where its outline narrows, and by what a solid misses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

ANGLES = 16
"""Directions of the cuts through the image."""
HULL_POINTS = 400
"""Points from which the hulls are computed. They are in random order."""
CUTS = 4
"""Best cuts through the image that are proposed."""
PLANE_POSITIONS = (0.3, 0.5, 0.7)
"""Positions of planes across the longest principal axis, as shares of the cloud's extent."""
MISSED_NOISE = 2.0
"""A solid misses points farther away than so many times the noise."""


def propose_cuts(
    points: NDArray[np.float64],
    image: NDArray[np.float64] | None,
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    noise: float,
    min_points: int,
) -> list[NDArray[np.bool_]]:
    """Propose cuts of a cloud as masks (N,) of the second part, without duplicates.

    Parameters
    ----------
    points
        (N, 3).
    image
        (N, 2) their positions in the image; None without a camera.
    neighbours
        (N, K) indices of the neighbours of each point, -1 for neighbours outside the cloud.
    residuals
        (N,) signed distances from the solid that is to be cut.
    noise
        Expected noise of the points, one standard deviation, in the unit of the points.
    min_points
        Minimum number of points on either side.
    """
    cuts: list[NDArray[np.bool_]] = []
    for mask in _all_cuts(points, image, neighbours, residuals, noise, min_points):
        count = int(np.count_nonzero(mask))
        if min(count, len(mask) - count) < min_points:
            continue
        if all(_difference(mask, other) > min_points // 2 for other in cuts):
            cuts.append(mask)
    return cuts


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


def image_cuts(image: NDArray[np.float64], count: int, min_points: int) -> list[NDArray[np.bool_]]:
    """Return the cuts of image points (N, 2) by lines that shrink their convex hulls most.

    Of each direction the best line is kept. A part that is convex in the image gains nothing by a
    cut, and a neck or a bend gains most.
    """
    few = image[:HULL_POINTS]
    margin = max(min_points * len(few) // len(image), 2)
    best: list[tuple[float, NDArray[np.float64], float]] = []
    for angle in np.arange(ANGLES) * np.pi / ANGLES:
        along = np.array([np.cos(angle), np.sin(angle)])
        across = np.array([-along[1], along[0]])
        position = few @ along
        order = np.argsort(position)
        sums = hull_area_sums(position[order], (few @ across)[order])[margin:-margin]
        if not len(sums):
            continue
        k = int(np.argmin(sums)) + margin
        threshold = 0.5 * (position[order[k]] + position[order[k + 1]])
        best.append((float(sums[k - margin]), along, float(threshold)))
    best.sort(key=lambda cut: cut[0])
    cuts: list[NDArray[np.bool_]] = []
    for _, along, threshold in best:
        mask = image @ along > threshold
        if all(_difference(mask, other) > max(0.1 * len(mask), min_points // 2) for other in cuts):
            cuts.append(mask)
        if len(cuts) == count:
            break
    return cuts


@njit(cache=True, nogil=True)
def hull_area_sums(x, y):
    """Return the areas (N - 1,) of the two hulls on either side of each cut.

    Cut k divides points 0..k from the others. The points are sorted by `x` (N,). One pass of the
    monotone chain (Andrew 1979) from either end gives the hulls of all cuts.
    """
    n = x.size
    return _prefix_areas(x, y)[: n - 1] + _prefix_areas(-x[::-1], y[::-1])[::-1][1:]


@njit(cache=True, nogil=True)
def _prefix_areas(x, y):
    """Return the areas (N,) of the hulls of the first 1, 2, ... points, sorted by x."""
    n = x.size
    areas = np.zeros(n)
    for side in (1.0, -1.0):
        stack, under = np.zeros(n, dtype=np.int64), np.zeros(n)
        top = 0
        for i in range(1, n):
            while top > 0:
                a, b = stack[top - 1], stack[top]
                turn = (x[b] - x[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (x[i] - x[a])
                if side * turn < 0.0:
                    break
                top -= 1
            b = stack[top]
            area = under[top] + 0.5 * (x[i] - x[b]) * (y[i] + y[b])
            top += 1
            stack[top], under[top] = i, area
            areas[i] += side * area
    return areas


def _all_cuts(
    points: NDArray[np.float64],
    image: NDArray[np.float64] | None,
    neighbours: NDArray[np.int64],
    residuals: NDArray[np.float64],
    noise: float,
    min_points: int,
) -> Iterator[NDArray[np.bool_]]:
    if image is not None:
        yield from image_cuts(image, CUTS, min_points)
    for missed in (residuals > MISSED_NOISE * noise, residuals < -MISSED_NOISE * noise):
        yield largest_cluster(missed, neighbours)
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    for column in (2,) if image is not None else (2, 1, 0):
        along = centred @ axes[:, column]
        low, high = along.min(), along.max()
        for position in PLANE_POSITIONS:
            yield along > low + position * (high - low)


def _difference(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> int:
    """Return how many points two cuts divide differently, in either order of the sides."""
    differing = int(np.count_nonzero(one ^ other))
    return min(differing, len(one) - differing)

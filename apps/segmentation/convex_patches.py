"""Join surface patches that are locally convex (LCCP)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from .baseline_tabletop import STEP_SHARE, Tabletop, finish, spread

CONVEX_ANGLE = 0.17
"""Patches whose normals differ by less are one surface, rad (10°, from Stein et al.)."""
GAP_PX = 4
"""Patches grow by this distance, so that they touch across the edge between them, px."""


def join_convex(
    patches: NDArray[np.int32],
    table: Tabletop,
    normals: NDArray[np.float32],
    *,
    min_border: int,
    extended: bool,
) -> NDArray[np.int32]:
    """Join neighbouring patches that form a convex or flat pair.

    Source: Stein, Schoeler, Papon and Wörgötter, "Object Partitioning Using Local Convexity",
    CVPR 2014. Two patches with centres x and normals n are convex when (x1 - x2) · (n1 - n2) > 0.

    Parameters
    ----------
    patches
        (H, W) int32; 0 = none.
    table
        The table and the pixels above it.
    normals
        Unit normals towards the camera, (H, W, 3).
    min_border
        Minimum number of touching pixel pairs of two neighbours.
    extended
        Join two patches only if a third patch is convex to both (their extended criterion). Use it
        for many small patches.

    Returns
    -------
    NDArray
        Labels of the objects, (H, W) int32; 0 = none.
    """
    seeds = np.where(table.above, patches, 0)
    grown = spread(seeds, table.above, GAP_PX)
    count = int(grown.max()) + 1
    centre = _sums(seeds, table.points, count)
    centre /= np.maximum(np.bincount(seeds.ravel(), minlength=count), 1)[:, None]
    normal = _unit(_sums(seeds, normals, count))
    first, second = _neighbours(grown, table.points[..., 2], min_border)
    direction = _unit(centre[first] - centre[second])
    convexity = np.sum(direction * (normal[first] - normal[second]), axis=1)
    flat = np.sum(normal[first] * normal[second], axis=1) > np.cos(CONVEX_ANGLE)
    join = (convexity > 0) | flat
    if extended and first.size:
        half = _graph(first[join], second[join], count).tocsr()
        convex = half + half.T
        join &= np.asarray((convex @ convex)[first, second]).ravel() > 0
    _, group = connected_components(_graph(first[join], second[join], count), directed=False)
    return finish(np.where(grown > 0, group[grown] + 1, 0), table.above)


def _sums(
    labels: NDArray[np.int32], values: NDArray[np.float32], count: int
) -> NDArray[np.float64]:
    """Sum of (H, W, 3) values over each label, (count, 3)."""
    flat = labels.ravel()
    sums = [np.bincount(flat, values[..., k].ravel(), count) for k in range(3)]
    return np.column_stack(sums).astype(np.float64)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)


def _graph(first: NDArray[np.int64], second: NDArray[np.int64], count: int) -> coo_array:
    return coo_array((np.ones(len(first)), (first, second)), shape=(count, count))


def _neighbours(
    patches: NDArray[np.int32], z: NDArray[np.float32], min_border: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pairs of patches that touch, also at corners, without a step in depth."""
    count = int(patches.max()) + 1
    pairs = []
    for one, other in (
        ((slice(None), slice(0, -1)), (slice(None), slice(1, None))),
        ((slice(0, -1), slice(None)), (slice(1, None), slice(None))),
        ((slice(0, -1), slice(0, -1)), (slice(1, None), slice(1, None))),
        ((slice(0, -1), slice(1, None)), (slice(1, None), slice(0, -1))),
    ):
        a, b = patches[one], patches[other]
        touch = (a != b) & (a > 0) & (b > 0) & (np.abs(z[one] - z[other]) < STEP_SHARE * z[one])
        low, high = np.minimum(a, b)[touch], np.maximum(a, b)[touch]
        pairs.append(low.astype(np.int64) * count + high)
    keys, lengths = np.unique(np.concatenate(pairs), return_counts=True)
    first, second = np.divmod(keys[lengths >= min_border], count)
    return first, second

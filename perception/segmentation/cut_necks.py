"""Cut patches at necks: narrow places between two broad parts that free space separates."""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from .connected_parts import connected_parts
from .free_space import count_free_lines
from .label_pixels import LINES, renumber_labels
from .sliver_pixels import clear_borders
from .working_image import WorkingImage

MIN_HALF_WIDTH = 10.0
"""Minimum half width of a part that can be cut off, px at the reference width. 8 cuts off parts of
tools, 12 gives the same result."""
NECK = 0.35
"""Maximum width of a neck, as a share of the width of the narrower part. 0.5 and 0.65 cut more
objects into parts, and the annotated frames gain nothing."""
MIN_FREE = 0.3
"""Minimum share of the lines between two parts that cross free space. Without this test objects
that lie in front of one another are cut and then joined wrongly."""
LEVELS = 8
"""Levels per pixel by which the distances to the outline are sorted."""


def cut_necks(patches: NDArray[np.int32], image: WorkingImage) -> NDArray[np.int32]:
    """Cut patches 1..n (H, W) where they are narrow; return new labels 1..m, 0 stays 0.

    Two objects whose surfaces continue each other at one place are a single patch there. The
    distance to the outline has a maximum in each of them and a saddle between: a watershed of the
    distance separates them. Parts stay together if the lines between them stay inside the surface.
    """
    kernel = np.ones((3, 3), np.uint8)
    # Single missing readings are no outline.
    inner = np.asarray(cv2.morphologyEx((patches > 0).astype(np.uint8), cv2.MORPH_CLOSE, kernel))
    clear_borders(patches, inner)
    distance = cv2.distanceTransform(inner, cv2.DIST_L2, 5)
    count = int(patches.max(initial=0))
    minimum = MIN_HALF_WIDTH * image.scale
    # Every second row and column shows which patches have several cores.
    cores = connected_parts((distance[::2, ::2] >= minimum).view(np.uint8)).labels
    several = _with_several(patches[::2, ::2], cores, count)
    if not several.any():
        return patches
    parts, owner = separate_parts(patches, several, distance, minimum, NECK)
    touching = _pairs_of_parts(owner)
    hollow = np.zeros(len(owner), np.bool_)
    free = count_free_lines(parts, touching, hollow, image) / LINES
    root = np.arange(len(owner))
    for a, b in touching[free < MIN_FREE].tolist():
        root[root == root[b]] = root[a]
    numbers = np.zeros(len(owner), np.int32)
    kept = np.unique(root[1:])
    numbers[kept] = np.arange(1, len(kept) + 1)
    return renumber_labels(parts, numbers[root])


def _with_several(
    patches: NDArray[np.int32], cores: NDArray[np.int32], count: int
) -> NDArray[np.bool_]:
    """Return the mask (n + 1,) of the patches that hold several cores."""
    first, last = np.full(count + 1, np.iinfo(np.int32).max), np.zeros(count + 1, np.int64)
    inside = cores > 0
    np.minimum.at(first, patches[inside], cores[inside])
    np.maximum.at(last, patches[inside], cores[inside])
    several = last > first
    several[0] = False
    return several


def _pairs_of_parts(owner: NDArray[np.int32]) -> NDArray[np.int64]:
    """Return the pairs (K, 2) of parts 1..m that were one patch, from the patch of each part."""
    cut = np.flatnonzero(np.bincount(owner[1:]) > 1)
    pairs = [pair for patch in cut for pair in combinations(np.flatnonzero(owner == patch), 2)]
    return np.array(pairs, np.int64).reshape(-1, 2)


@njit(cache=True, nogil=True)
def separate_parts(patches, several, distance, min_peak, neck):
    """Separate the parts of some patches by a watershed of the distance to their outline.

    Pixels are visited by falling distance. Where two parts meet, they stay apart if both have a
    distance of at least `min_peak` and the place is narrower than `neck` times the narrower one.

    Parameters
    ----------
    patches, distance
        Labels 1..n and distances in px, both (H, W).
    several
        (n + 1,) bool: patches that may be cut.
    min_peak, neck
        Half width of a part, px, and the relative width of a neck.

    Returns
    -------
    parts, owner
        Labels 1..m (H, W) int32, and the patch of each part, (m + 1,).
    """
    flat, away, columns = patches.ravel(), distance.ravel(), patches.shape[1]
    order = _by_falling_distance(flat, several, away)
    part_of = np.full(flat.size, -1, np.int64)
    parent, peak = np.arange(len(order)), np.zeros(len(order), np.float32)
    count = 0
    for k in order:
        own = -1
        for side in (-columns, columns, -1, 1):
            other = k + side
            if other < 0 or other >= flat.size or part_of[other] < 0 or flat[other] != flat[k]:
                continue
            if abs(side) == 1 and other // columns != k // columns:
                continue
            near = _root(parent, part_of[other])
            if own < 0:
                own = near
            elif near != own:
                broad, narrow = (own, near) if peak[own] >= peak[near] else (near, own)
                own = broad
                if peak[narrow] < min_peak or away[k] >= neck * peak[narrow]:
                    parent[narrow] = broad
        if own < 0:
            own = count
            peak[own] = away[k]
            count += 1
        part_of[k] = own
    return _numbered(patches, several, part_of, parent)


@njit(cache=True, nogil=True)
def _by_falling_distance(flat, several, away):
    """Return the flat indices of the pixels of some patches, largest distance first."""
    levels = int(away.max() * LEVELS) + 1
    start = np.zeros(levels + 1, np.int64)
    for k in range(flat.size):
        if several[flat[k]]:
            start[levels - int(away[k] * LEVELS)] += 1
    for level in range(1, levels + 1):
        start[level] += start[level - 1]
    order = np.empty(start[levels], np.int64)
    for k in range(flat.size - 1, -1, -1):
        if several[flat[k]]:
            level = levels - int(away[k] * LEVELS)
            start[level] -= 1
            order[start[level]] = k
    return order


@njit(cache=True, nogil=True)
def _root(parent, part):
    while parent[part] != part:
        parent[part] = parent[parent[part]]
        part = parent[part]
    return part


@njit(cache=True, nogil=True)
def _numbered(patches, several, part_of, parent):
    """Number the parts, and the patches that were not cut, in the order of their pixels."""
    flat = patches.ravel()
    labels, owner = np.zeros(flat.size, np.int32), np.zeros(len(several) + len(parent), np.int32)
    of_patch, of_part = np.zeros(len(several), np.int32), np.zeros(len(parent), np.int32)
    count = 0
    for k in range(flat.size):
        patch = flat[k]
        if patch <= 0:
            continue
        part = _root(parent, part_of[k]) if several[patch] else -1
        number = of_part[part] if part >= 0 else of_patch[patch]
        if number == 0:
            count += 1
            number = count
            owner[count] = patch
            if part >= 0:
                of_part[part] = number
            else:
                of_patch[patch] = number
        labels[k] = number
    return labels.reshape(patches.shape), owner[: count + 1]

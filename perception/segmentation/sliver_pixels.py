"""Compiled steps of the handling of slivers: widths of patches, and replacement of pixels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import count_labels


def replace_by_nearest(
    patches: NDArray[np.int32], replaced: NDArray[np.bool_], reach: int
) -> NDArray[np.int32]:
    """Replace the pixels of some patches by the nearest other patch; 0 if none is within `reach`.

    Parameters
    ----------
    patches
        Labels 1..n (H, W), 0 = no patch.
    replaced
        (n + 1,) bool: the patches to replace.
    reach
        Maximum distance of the other patch, px.
    """
    side = np.arange(-reach, reach + 1)
    steps = np.stack(np.meshgrid(side, side, indexing="ij"), axis=-1).reshape(-1, 2)
    distances = (steps**2).sum(axis=1)
    order = np.argsort(distances, kind="stable")
    order = order[(distances[order] <= reach**2) & (distances[order] > 0)]
    return nearest_patches(patches, replaced, steps[order])


@njit(cache=True, nogil=True)
def nearest_patches(patches, replaced, steps):
    """Compute :func:`replace_by_nearest` from the steps (K, 2) to the neighbours, nearest first."""
    rows, columns = patches.shape
    result = patches.copy()
    for v in range(rows):
        for u in range(columns):
            if not replaced[patches[v, u]]:
                continue
            result[v, u] = 0
            for k in range(len(steps)):
                y, x = v + steps[k, 0], u + steps[k, 1]
                if y < 0 or x < 0 or y >= rows or x >= columns:
                    continue
                other = patches[y, x]
                if other > 0 and not replaced[other]:
                    result[v, u] = other
                    break
    return result


@njit(cache=True, nogil=True)
def clear_borders(patches, mask):
    """Set the mask (H, W) to 0 on both sides of each border between two patches, and at the edge.

    The mask is changed in place.
    """
    rows, columns = patches.shape
    mask[0], mask[-1] = 0, 0
    mask[:, 0], mask[:, -1] = 0, 0
    for v in range(rows):
        for u in range(columns):
            here = patches[v, u]
            if here == 0:
                continue
            if u + 1 < columns and patches[v, u + 1] != here and patches[v, u + 1] > 0:
                mask[v, u] = mask[v, u + 1] = 0
            if v + 1 < rows and patches[v + 1, u] != here and patches[v + 1, u] > 0:
                mask[v, u] = mask[v + 1, u] = 0


@njit(cache=True, nogil=True)
def measure_patches(patches, distance, count):
    """Return the size and the largest distance of each patch 0..`count`, two of (count + 1,)."""
    sizes, largest = count_labels(patches, count), np.zeros(count + 1, np.float32)
    # A run of equal labels needs one comparison with the largest distance so far.
    flat, distances = patches.ravel(), distance.ravel()
    present, high = 0, np.float32(0.0)
    for k in range(flat.size):
        label = flat[k]
        if label != present:
            largest[present] = max(largest[present], high)
            present, high = label, np.float32(0.0)
        high = max(high, distances[k])
    largest[present] = max(largest[present], high)
    return sizes, largest

"""Access to the pixels of labelled regions, and evenly spread samples of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

LINES = 48
"""Straight lines that are tested between two regions. More are more reliable and take longer."""
SHUFFLE = 1009
"""A prime above the number of lines: its multiples pair every part of a region with every other."""


class LabelPixels(NamedTuple):
    """Flat pixel indices of all regions, sorted by label."""

    order: NDArray[np.int32]
    """Flat pixel indices, those of label 1 first."""
    starts: NDArray[np.int64]
    """(n + 2,): pixels of label k are ``order[starts[k]:starts[k + 1]]``."""


@njit(cache=True, nogil=True)
def pixels_by_label(labels, count):
    """Return the `LabelPixels` of the labels 1..count of an image (H, W)."""
    flat = labels.ravel()
    starts = np.zeros(count + 2, np.int64)
    sizes = count_labels(labels, count)
    for label in range(1, count + 1):
        starts[label + 1] = starts[label] + sizes[label]
    order = np.empty(starts[count + 1], np.int32)
    following = starts.copy()
    # A run of equal labels needs no access to `following`.
    present, at = 0, 0
    for k in range(flat.size):
        label = flat[k]
        if label != present:
            following[present] = at
            present, at = label, following[label]
        if label > 0:
            order[at] = k
            at += 1
    return LabelPixels(order, starts)


@njit(cache=True, nogil=True)
def count_labels(labels, count):
    """Return the number of pixels of each label 0..`count` of an image (H, W), int64.

    ``np.bincount`` converts the whole image to int64 first and takes three times as long.
    """
    sizes = np.zeros(count + 1, np.int64)
    # A run of equal labels is counted at once.
    present, run = 0, 0
    for label in labels.ravel():
        if label != present:
            sizes[present] += run
            present, run = label, 0
        run += 1
    sizes[present] += run
    return sizes


@njit(cache=True, nogil=True)
def renumber_labels(labels, numbers):
    """Replace each label of an image (H, W) by its number in `numbers` (n + 1,), int32.

    ``np.take`` converts the whole image to int64 first and takes three times as long.
    """
    result = np.empty(labels.shape, np.int32)
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            result[v, u] = numbers[labels[v, u]]
    return result


@njit(cache=True, nogil=True)
def sample_pixel(pixels, label, i, samples):
    """Return the flat index of the i-th of `samples` pixels spread evenly over a region."""
    size = pixels.starts[label + 1] - pixels.starts[label]
    return pixels.order[pixels.starts[label] + (2 * i + 1) * size // (2 * samples)]


@njit(cache=True, nogil=True)
def line_end(i, samples):
    """Return the sample of the second region at which the i-th line from the first one ends."""
    return (i * SHUFFLE + 7) % samples

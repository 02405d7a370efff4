"""Tests of the access to the pixels of regions: equality with NumPy."""

import numpy as np
import pytest

from eyehand.perception.segmentation.label_pixels import (
    count_labels,
    pixels_by_label,
    renumber_labels,
)


@pytest.mark.parametrize("seed", range(4))
def test_counts_numbers_and_pixels_equal_numpy(seed):
    rng = np.random.default_rng(seed)
    # Rows with runs of equal labels, and rows without.
    labels = np.repeat(rng.integers(0, 6, (9, 5)), rng.integers(1, 6, 5), axis=1).astype(np.int32)
    labels[::3] = rng.integers(0, 6, labels[::3].shape)
    assert np.array_equal(count_labels(labels, 7), np.bincount(labels.ravel(), minlength=8))
    numbers = rng.integers(0, 9, 8).astype(np.int32)
    assert np.array_equal(renumber_labels(labels, numbers), numbers[labels])
    order, starts = pixels_by_label(labels, 7)
    for label in range(1, 8):
        pixels = order[starts[label] : starts[label + 1]]
        assert np.array_equal(pixels, np.flatnonzero(labels == label))

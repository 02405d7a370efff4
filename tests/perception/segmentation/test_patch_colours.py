"""Overlap of the colours of patches: a NumPy reference, print, light and misalignment."""

import numpy as np
import pytest

from eyehand.perception.segmentation.patch_colours import (
    BINS,
    colour_histograms,
    colour_overlaps,
    lab_table,
)

PAIRS = np.array([[1, 2]])
HALVES = np.repeat([[1, 2]], 20, axis=1).repeat(30, axis=0).astype(np.int32)
"""Two patches side by side, (30, 40)."""


def overlap(first, second):
    """Return the overlap of two patches from their RGB, each a colour or an image (30, 20, 3)."""
    colour = np.empty((*HALVES.shape, 3), np.uint8)
    colour[:, :20], colour[:, 20:] = first, second
    return float(colour_overlaps(HALVES, colour, PAIRS)[0])


def reference(patches, colour, count):
    """Share every pixel among the 8 bins around its colour."""
    histograms = np.zeros((count + 1, *BINS))
    inside = patches > 0
    at = lab_table()[tuple((colour[inside] >> 3).T)]
    low = np.floor(at).astype(int)
    for offset in np.ndindex(2, 2, 2):
        shares = np.where(offset, at - low, 1 - at + low).prod(axis=1)
        np.add.at(histograms, (patches[inside], *(low + offset).T), shares)
    return histograms


def test_histograms_equal_reference():
    rng = np.random.default_rng(0)
    patches = rng.integers(0, 5, (40, 50)).astype(np.int32)
    colour = rng.integers(0, 256, (40, 50, 3)).astype(np.uint8)
    histograms = colour_histograms(patches, colour, lab_table(), 4)
    assert np.allclose(histograms, reference(patches, colour, 4), atol=1e-4)
    sizes = np.bincount(patches[patches > 0], minlength=5)
    assert np.allclose(histograms.sum(axis=(1, 2, 3)), sizes, atol=1e-3)


def test_overlap_equals_bhattacharyya_coefficient():
    colour = (
        np.random.default_rng(1).integers(0, 256, (*HALVES.shape, 3)).astype(np.uint8) // 64 * 64
    )
    first, second = reference(HALVES, colour, 2)[1:] / 600
    expected = np.sqrt(first * second).sum()
    assert colour_overlaps(HALVES, colour, PAIRS)[0] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("colour", [(220, 30, 40), (128, 128, 128), (0, 0, 0), (255, 255, 255)])
def test_noise_changes_the_overlap_of_equal_colours_little(colour):
    noise = np.random.default_rng(2).normal(0, 3, (2, 30, 20, 1))
    first, second = np.clip(np.array(colour) + noise, 0, 255)
    assert overlap(colour, colour) == pytest.approx(1.0, abs=1e-6)
    assert overlap(first, second) > 0.9


def test_shade_changes_the_overlap_less_than_colour():
    red, green, dark_red = (200, 40, 40), (40, 160, 40), (170, 34, 34)
    assert overlap(red, green) == 0.0
    assert overlap(red, dark_red) > 0.6


def test_same_print_overlaps():
    rng = np.random.default_rng(3)
    inks = np.array([(230, 200, 20), (20, 40, 160), (240, 240, 240)])
    first, second = inks[rng.choice(3, (2, 30, 20), p=(0.5, 0.3, 0.2))]
    assert overlap(first, second) > 0.95


def test_misalignment_by_three_pixels_keeps_colours_apart():
    colour = np.empty((*HALVES.shape, 3), np.uint8)
    colour[:, :23], colour[:, 23:] = (200, 40, 40), (40, 40, 200)
    assert colour_overlaps(HALVES, colour, PAIRS)[0] < 0.45


def test_table_covers_all_colours_within_the_bins():
    table = lab_table()
    assert table.shape == (32, 32, 32, 3)
    assert (table >= 0).all()
    assert (table < np.array(BINS) - 1).all()
    grey = np.arange(32)
    assert np.allclose(table[grey, grey, grey, 1:], 8.0, atol=0.1)

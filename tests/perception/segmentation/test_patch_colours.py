"""Evidence of colours: a NumPy reference, print, rare colours, light and misalignment."""

import numpy as np
import pytest

from eyehand.perception.segmentation.patch_colours import (
    BINS,
    BORDER_WEIGHT,
    MAX_SAMPLES,
    MISALIGNED,
    OWN_SHARE,
    colour_evidence,
    colour_histograms,
    lab_table,
)

RED, GREEN, BLUE, WHITE = (200, 40, 40), (40, 160, 40), (40, 40, 200), (240, 240, 240)
STRIPES = np.repeat([[1, 2, 3, 4]], 15, axis=1).repeat(30, axis=0).astype(np.int32)
"""Four patches side by side, (30, 60)."""


def evidence(*sides, first=1, second=2):
    """Return the evidence for two of four stripes from their RGB, a colour or (30, 15, 3) each."""
    colour = np.empty((*STRIPES.shape, 3), np.uint8)
    for number, side in enumerate(sides):
        colour[:, 15 * number : 15 * (number + 1)] = side
    return float(colour_evidence(STRIPES, colour, np.array([[first, second]]))[0])


def reference(patches, colour, count):
    """Share the pixels of patches with few pixels among the 8 bins around their colours."""
    histograms = np.zeros((count + 1, *BINS))
    for v, u in np.argwhere(patches > 0):
        ends = [
            (v + dv * MISALIGNED, u + du * MISALIGNED)
            for dv, du in ((0, 1), (1, 0), (0, -1), (-1, 0))
        ]
        inside = all(
            0 <= y < patches.shape[0]
            and 0 <= x < patches.shape[1]
            and patches[y, x] == patches[v, u]
            for y, x in ends
        )
        at = lab_table()[tuple(colour[v, u] >> 3)]
        low = np.floor(at).astype(int)
        for offset in np.ndindex(2, 2, 2):
            share = np.where(offset, at - low, 1 - at + low).prod()
            histograms[(patches[v, u], *(low + offset))] += share * (1 if inside else BORDER_WEIGHT)
    return histograms


def random_patches():
    rng = np.random.default_rng(0)
    blocks = np.arange(10, dtype=np.int32).reshape(2, 5) % 5
    patches = blocks.repeat(9, axis=0).repeat(8, axis=1)
    return patches, rng.integers(0, 256, (*patches.shape, 3)).astype(np.uint8)


def test_histograms_equal_reference():
    patches, colour = random_patches()
    histograms = colour_histograms(patches, colour, lab_table(), 4)
    assert np.bincount(patches.ravel())[1:].max() <= MAX_SAMPLES
    assert np.allclose(histograms, reference(patches, colour, 4), atol=1e-3)


def test_evidence_equals_reference():
    patches, colour = random_patches()
    shares = reference(patches, colour, 4).reshape(5, -1)[1:]
    shares /= shares.sum(axis=1, keepdims=True)
    sizes = np.bincount(patches.ravel())[1:]
    scene = sizes @ shares / sizes.sum()
    ratio = np.log(OWN_SHARE * shares / np.where(scene > 0, scene, 1) + 1 - OWN_SHARE)
    expected = (shares[0] @ ratio[2] + shares[2] @ ratio[0]) / 2
    assert colour_evidence(patches, colour, np.array([[1, 3]]))[0] == pytest.approx(
        expected, abs=1e-4
    )


def test_same_colour_is_for_and_different_colours_are_against_one_object():
    assert evidence(RED, RED, GREEN, BLUE) > 0.3
    assert evidence(RED, GREEN, BLUE, WHITE) < -0.8


def test_rare_colour_is_stronger_evidence_than_a_common_one():
    assert evidence(RED, RED, WHITE, WHITE) > evidence(RED, RED, RED, WHITE) + 0.2
    assert abs(evidence(WHITE, WHITE, WHITE, WHITE)) < 0.01


def test_same_print_is_for_one_object():
    rng = np.random.default_rng(3)
    inks = np.array([(230, 200, 20), (20, 40, 160), WHITE])
    first, second = inks[rng.choice(3, (2, 30, 15), p=(0.5, 0.3, 0.2))]
    assert evidence(first, second, RED, GREEN) > 0.3


def test_shade_weakens_the_evidence_and_keeps_its_sign():
    assert 0 < evidence(RED, (170, 34, 34), GREEN, BLUE) < evidence(RED, RED, GREEN, BLUE)


def test_misalignment_by_two_pixels_changes_little():
    colour = np.empty((*STRIPES.shape, 3), np.uint8)
    for number, side in enumerate((RED, GREEN, BLUE, WHITE)):
        colour[:, 15 * number + 2 * (number > 0) :] = side
    aligned = evidence(RED, GREEN, BLUE, WHITE)
    assert colour_evidence(STRIPES, colour, np.array([[1, 2]]))[0] == pytest.approx(
        aligned, abs=0.15
    )


def test_narrow_patch_has_a_colour():
    patches = STRIPES.copy()
    patches[:, 15:18] = 5
    colour = np.full((*STRIPES.shape, 3), RED, np.uint8)
    colour[patches == 5] = BLUE
    assert colour_evidence(patches, colour, np.array([[1, 5]]))[0] < -0.5


def test_large_patches_are_sampled():
    patches = np.ones((60, 70), np.int32)
    colour = np.full((60, 70, 3), RED, np.uint8)
    total = colour_histograms(patches, colour, lab_table(), 1).sum()
    assert 0.4 * MAX_SAMPLES < total <= MAX_SAMPLES + 1


def test_table_covers_all_colours_within_the_bins():
    table = lab_table()
    assert table.shape == (32, 32, 32, 3)
    assert (table >= 0).all()
    assert (table < np.array(BINS) - 1).all()
    grey = np.arange(32)
    assert np.allclose(table[grey, grey, grey, 1:], 8.0, atol=0.1)

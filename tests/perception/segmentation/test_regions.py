"""Tests of region borders and of relabelling regions by size."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_planes import image_of, random_planes

from eyehand.perception.segmentation import regions
from eyehand.perception.segmentation.local_planes import LocalPlanes
from eyehand.perception.segmentation.regions import (
    ABOVE,
    BELOW,
    CLOSE_GAP,
    LEFT,
    MAX_REGIONS,
    RIGHT,
    border_counts,
    count_border_pairs,
    fill_holes,
    relabel_by_size,
)

FLAT = LocalPlanes(*(np.zeros((6, 9), np.float32) for _ in range(4)))


def reference(labels, q, planes, count, max_step, max_crease, max_gap):
    """Count borders from the list of readings of every row and column."""
    value, slope_u, slope_v = planes[:3]
    contact, occluding = np.zeros((2, count + 1, count + 1, 4), int)
    not_behind, blind = np.zeros((count + 1, count + 1), int), np.zeros((count + 1, 4), int)
    lines = [([(v, u) for u in range(q.shape[1])], slope_u, RIGHT, LEFT) for v in range(q.shape[0])]
    lines += [
        ([(v, u) for v in range(q.shape[0])], slope_v, BELOW, ABOVE) for u in range(q.shape[1])
    ]
    for pixels, slope, ahead, back in lines:
        known = [k for k, pixel in enumerate(pixels) if q[pixel] > 0]
        if known:
            blind[labels[pixels[known[0]]], back] += 1
            blind[labels[pixels[known[-1]]], ahead] += 1
        for i, j in pairwise(known):
            first, second = pixels[i], pixels[j]
            a, b = labels[first], labels[second]
            if j - i > max_gap + 1:
                blind[a, ahead] += 1
                blind[b, back] += 1
                continue
            if a == b:
                continue
            depth_step = 1.0 / float(q[second]) - 1.0 / float(q[first])
            not_behind[a, b] += depth_step >= -CLOSE_GAP
            not_behind[b, a] += depth_step <= CLOSE_GAP
            rise = float(q[second]) - float(q[first])
            error_a, error_b = (rise - float(slope[at]) * (j - i) for at in (first, second))
            step = abs(error_a) + abs(error_b) - min(abs(error_b - error_a), max_crease)
            if value[first] > 0 and value[second] > 0 and step < max_step:
                contact[a, b, ahead] += 1
                contact[b, a, back] += 1
            elif rise < 0:
                occluding[a, b, ahead] += 1
            else:
                occluding[b, a, back] += 1
    return contact, occluding, not_behind, blind


@given(seed=st.integers(0, 10_000), gap=st.integers(1, 4), missing=st.sampled_from([0.1, 0.6]))
@settings(max_examples=20)
def test_border_counts_equal_count_over_reading_pairs(seed, gap, missing):
    labels, q, planes = random_planes(seed, missing=missing)
    inputs = labels, q, planes, 4, np.float32(0.006), np.float32(0.004), gap
    result, expected = border_counts(*inputs), reference(*inputs)
    for counts, expected_counts in zip(result, expected, strict=True):
        assert np.array_equal(counts, expected_counts)


def test_depth_step_has_near_side_and_level_border_is_contact():
    labels = np.zeros((6, 9), np.int32)
    labels[:, 3:6], labels[:, 6:] = 1, 2
    q = np.where(labels == 2, np.float32(0.8), np.float32(1.0))
    planes = FLAT._replace(value=q)
    borders = count_border_pairs(labels, image_of(q), planes)
    assert borders.contact[0, 1, RIGHT] == borders.contact[1, 0, LEFT] == 6
    assert borders.occluding[1, 2, RIGHT] == 6
    assert not borders.occluding[2].any()
    # A nearer region counts as close to the region behind it. The reverse fails over 25 cm.
    assert borders.not_behind[1, 2] == borders.not_behind[0, 1] == borders.not_behind[1, 0] == 6
    assert borders.not_behind[2, 1] == 0
    assert borders.blind[2].tolist() == [6, 0, 3, 3]
    assert borders.perimeter(1) == 6 + 6 + 3 + 3


@pytest.mark.parametrize(("width", "contact"), [(4, 6), (5, 0)])
def test_narrow_gap_without_readings_keeps_contact(monkeypatch, width, contact):
    labels = np.zeros((6, 9), np.int32)
    labels[:, :2], labels[:, 2 + width :] = 1, 2
    q = np.where(labels > 0, np.float32(1.0), np.float32(0.0))
    monkeypatch.setattr(regions, "MAX_GAP", 4)
    borders = count_border_pairs(labels, image_of(q), FLAT._replace(value=q))
    assert borders.contact[1, 2, RIGHT] == contact
    assert borders.blind[1, RIGHT] == 6 - contact


def test_regions_are_relabelled_by_size_and_small_ones_removed():
    labels = np.array([[7, 7, 7, 2], [2, 7, 0, 5], [9, 9, 2, 0]], np.int32)
    expected = np.array([[1, 1, 1, 2], [2, 1, 0, 0], [3, 3, 2, 0]])
    assert np.array_equal(relabel_by_size(labels, 2), expected)
    assert not relabel_by_size(labels, 5).any()
    assert not relabel_by_size(np.zeros_like(labels), 1).any()


def test_largest_regions_are_kept_at_region_limit():
    labels = np.arange(1, MAX_REGIONS + 51, dtype=np.int32)
    labels = np.concatenate([labels, labels[-20:]])[None]
    kept = relabel_by_size(labels, 1)
    assert kept.max() == MAX_REGIONS
    assert (kept[0, -20:] > 0).all()


def test_holes_are_filled_and_notches_kept():
    ring = np.zeros((9, 9), bool)
    ring[1:8, 1:8] = True
    ring[3:6, 3:6] = False
    notch = ring.copy()
    notch[4, 5:] = False
    assert fill_holes(ring).sum() == 49
    assert np.array_equal(fill_holes(notch), notch)

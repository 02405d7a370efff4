"""Tests of the vote of three segmentations: majorities join parts, and minorities are reported."""

import numpy as np
from synthetic_balls import ball_frame

from eyehand.perception import SegmentationOptions, segment
from eyehand.perception.segmentation.ambiguity import NEARLY, SCALES
from eyehand.perception.segmentation.scale_vote import vote_scales


def _labels(left: int, middle: int, right: int) -> np.ndarray:
    """Return labels of three parts of equal size."""
    return np.repeat(np.array([[left, middle, right]], np.int32), 10, axis=1).repeat(10, axis=0)


def test_majority_joins_parts_and_each_minority_is_reported():
    # The first two join the left and the middle, the last one joins the middle and the right.
    labels, disputed = vote_scales([_labels(1, 1, 2), _labels(3, 3, 1), _labels(1, 2, 2)], 40)
    left, middle, right = labels[0, 5], labels[0, 15], labels[0, 25]
    assert left == middle > 0
    assert right not in (0, left)
    assert {one.reason for one in disputed} == {SCALES, NEARLY}
    split = next(one for one in disputed if one.reason == SCALES)
    assert labels.flat[split.pixel_a] == labels.flat[split.pixel_b] == left


def test_what_no_segmentation_disputes_stays_and_the_first_one_decides_the_background():
    labels, disputed = vote_scales([_labels(1, 2, 0), _labels(2, 1, 3), _labels(1, 2, 3)], 40)
    assert len(np.unique(labels)) == 3
    assert not labels[:, 20:].any()
    assert disputed == []


def test_small_part_joins_the_object_of_the_majority():
    first, second = _labels(1, 2, 2), _labels(1, 2, 2)
    first[:3, 8:10] = 2
    labels, disputed = vote_scales([first, second, second], 40)
    assert labels[0, 9] == labels[5, 9] != labels[0, 15]
    assert disputed == []


def test_segmentation_by_vote_finds_balls():
    frame, truth = ball_frame([(-0.12, 0.62, 0.05), (0.0, 0.75, 0.04), (0.13, 0.6, 0.045)])
    found = segment(frame, SegmentationOptions(scale_vote=True))
    assert found.count == 3
    assert not found.ambiguous
    assert "vote" in found.timings
    assert np.mean((found.labels > 0) == (truth > 0)) > 0.98

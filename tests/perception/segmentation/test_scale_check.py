"""Tests of the check at a lower resolution: objects on which both segmentations disagree."""

import numpy as np
import pytest
from synthetic_balls import ball_frame

from eyehand.perception import CameraIntrinsics, SegmentationOptions, segment
from eyehand.perception.segmentation.ambiguity import SCALES
from eyehand.perception.segmentation.scale_check import disputed_objects


def _labels(*parts: int) -> np.ndarray:
    """Return labels of parts of equal size, side by side."""
    return np.repeat(np.array([parts], np.int32), 10, axis=1).repeat(10, axis=0)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ((1, 1, 2), (2, 2, 1), []),
        ((1, 1, 2), (1, 3, 2), [1]),
        ((1, 1, 2, 2), (1, 1, 1, 2), [2]),
        ((1, 2, 3), (1, 2, 0), [3]),
        ((0, 1, 1), (2, 1, 1), []),
        ((0, 0, 1), (0, 0, 0), [1]),
        # Few readings of a neighbour are no dispute. A join with a small one disputes only that.
        ((1,) * 12 + (2,) * 12, (1,) * 11 + (2,) * 13, []),
        ((1,) * 12 + (2,), (1,) * 13, [2]),
    ],
)
def test_objects_divided_joined_or_lost_by_the_other_segmentation(first, second, expected):
    assert disputed_objects(_labels(*first), _labels(*second)) == expected


def test_two_balls_joined_to_one_are_named_and_no_label_changes():
    camera = CameraIntrinsics(520.0, 520.0, 319.5, 239.5, 640, 480)
    frame, _ = ball_frame([(0.0, 0.65, 0.04), (0.048, 0.65, 0.04)], camera)
    checked, unchecked = (
        segment(frame, SegmentationOptions(scale_check=on)) for on in (True, False)
    )
    assert checked.count == 1
    assert (checked.ambiguous, unchecked.ambiguous) == ({1: SCALES}, {})
    np.testing.assert_array_equal(checked.labels, unchecked.labels)
    assert "scale_check" in checked.timings


@pytest.mark.parametrize(("width", "height", "checked"), [(447, 335, False), (449, 337, True)])
def test_images_from_448_columns_on_are_checked_also_of_odd_size(width, height, checked):
    camera = CameraIntrinsics(364.0, 364.0, 223.5, 167.5, width, height)
    frame, _ = ball_frame([(0.0, 0.65, 0.04)], camera)
    found = segment(frame)
    assert found.count == 1
    assert ("scale_check" in found.timings) == checked

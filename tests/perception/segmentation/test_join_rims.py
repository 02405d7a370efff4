"""Tests of joining the parts of an empty vessel whose whole rim is visible."""

import numpy as np
import pytest
from synthetic_solids import Ball, Bowl, Box, Plate, exact_image, heights, solid_frame

from eyehand.perception.segmentation.join_rims import join_rims
from eyehand.perception.segmentation.result import SupportPlane

BOWL = Bowl(0.0, 0.65, 0.12, 0.12, 0.11)
VESSEL = (BOWL, BOWL.inside())
TABLE = SupportPlane(np.array([0.0, -0.8, -0.6]), 0.6, 0.002)


def join(*others, wall=VESSEL):
    """Return the labels before and after the join: the left half of each surface is a region."""
    frame, truth = solid_frame([*wall, *others])
    columns = np.broadcast_to(np.arange(truth.shape[1]), truth.shape)
    left = (truth > 0) & (columns < 160)
    labels = np.where(left, truth + truth.max(), truth).astype(np.int32)
    candidates = heights(frame) > 0.006
    labels[~candidates] = 0
    return truth, labels, join_rims(labels, candidates, exact_image(frame), TABLE)


def test_table_is_that_of_the_solids():
    frame, _ = solid_frame([])
    seen = frame.depth > 0
    np.testing.assert_allclose(TABLE.height(frame.points()[seen]), 0.0, atol=1e-6)


def test_parts_of_empty_vessel_become_one_region():
    truth, labels, whole = join()
    assert np.count_nonzero(np.unique(labels)) == 4
    assert len(np.unique(whole[labels > 0])) == 1
    assert np.array_equal(whole > 0, truth > 0)


def test_unlabelled_readings_join_vessel():
    frame, truth = solid_frame(VESSEL)
    labels = np.where(heights(frame) < 0.05, 0, truth).astype(np.int32)
    whole = join_rims(labels, heights(frame) > 0.006, exact_image(frame), TABLE)
    assert np.array_equal(whole > 0, truth > 0)


@pytest.mark.parametrize(
    "content", [Ball(0.0, 0.65, 0.05, 0.035), Box(0.0, 0.65, (0.06, 0.06, 0.06), base=0.01)]
)
def test_vessel_with_contents_stays_as_it_is(content):
    _, labels, whole = join(content)
    assert np.array_equal(whole, labels)


def test_neighbour_stays_a_region_of_its_own():
    truth, labels, whole = join(Box(0.16, 0.65, (0.07, 0.07, 0.06)))
    box = truth == 3
    assert len(np.unique(whole[(labels > 0) & ~box])) == 1
    assert np.array_equal(whole[box], labels[box])


def test_objects_in_a_circle_stay_separate():
    angles = np.arange(8) * np.pi / 4
    boxes = [
        Box(0.1 * np.cos(a), 0.65 + 0.1 * np.sin(a), (0.06, 0.075, 0.06), yaw=a) for a in angles
    ]
    _, labels, whole = join(*boxes, wall=())
    assert np.array_equal(whole, labels)


def test_object_without_rim_stays_as_it_is():
    _, labels, whole = join(Box(0.0, 0.6, (0.12, 0.12, 0.1)), wall=())
    assert np.array_equal(whole, labels)


def test_whole_vessel_is_not_searched():
    frame, truth = solid_frame(VESSEL, (Plate(),))
    labels = (truth > 0).astype(np.int32)
    whole = join_rims(labels, labels > 0, exact_image(frame), TABLE)
    assert np.array_equal(whole, labels)

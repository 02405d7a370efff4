"""Tests of joining the inside of an open vessel to its outside."""

import numpy as np
import pytest
from synthetic_solids import Ball, Bowl, Box, Plate, Solid, exact_image, heights, solid_frame

from eyehand.perception import SegmentationOptions, segment
from eyehand.perception.segmentation.join_open import join_open
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.regions import relabel_by_size

OPTIONS = SegmentationOptions().scaled(320)
BOWL = Bowl(0.0, 0.65, 0.12, 0.12, 0.11)
VESSEL: list[Solid] = [BOWL, BOWL.inside()]
BALL = Ball(0.0, 0.65, 0.045, 0.035)


def join(solids, change=lambda labels: labels):
    """Return the labels of exact surfaces before and after the join."""
    frame, labels = solid_frame(solids, (Plate(),))
    labels = change(labels)
    image = exact_image(frame)
    return labels, join_open(labels, image, fit_local_planes(image, OPTIONS))


def test_inside_joins_outside():
    labels, whole = join(VESSEL)
    assert np.array_equal(whole, np.minimum(labels, 1))


def test_unlabelled_bottom_joins_vessel():
    frame, truth = solid_frame(VESSEL, (Plate(),))
    height = heights(frame)
    low = (truth == 2) & (height < 0.02)
    assert np.count_nonzero(low) > 100
    _, whole = join(VESSEL, lambda labels: np.where(low, 0, labels).astype(np.int32))
    assert np.array_equal(whole, np.minimum(truth, 1))


def test_bottom_that_is_a_region_joins_vessel():
    frame, truth = solid_frame(VESSEL, (Plate(),))
    low = (truth == 2) & (heights(frame) < 0.02)
    _, whole = join(VESSEL, lambda labels: np.where(low, 3, labels).astype(np.int32))
    assert np.array_equal(whole, np.minimum(truth, 1))


@pytest.mark.parametrize(
    "other",
    [
        BALL,
        Ball(0.18, 0.65, 0.05, 0.05),
        Ball(0.0, 0.47, 0.03, 0.03),
        Box(0.0, 0.85, (0.3, 0.05, 0.2)),
    ],
)
def test_object_in_or_beside_bowl_stays_separate(other):
    labels, whole = join([*VESSEL, other])
    assert np.array_equal(whole, relabel_by_size(np.where(labels == 2, 1, labels)))


def test_concave_neighbours_stay_separate():
    solids: list[Solid] = [Box(0.0, 0.8, (0.3, 0.05, 0.2)), Box(0.0, 0.7, (0.3, 0.15, 0.05))]
    labels, same = join(solids)
    assert np.array_equal(same, labels)


def test_inside_without_outside_stays_unchanged():
    labels, same = join([BOWL.inside()])
    assert np.array_equal(same, labels)


@pytest.mark.parametrize(("inside", "count"), [([], 1), ([BALL], 2)])
def test_bowl_and_ball_in_it_are_two_objects(inside, count):
    frame, truth = solid_frame([*VESSEL, *inside], (Plate(),))
    segmentation = segment(frame)
    assert segmentation.count == count
    whole = np.where(truth == 2, 1, truth)
    for label, true_label in enumerate((1, 3)[:count], start=1):
        intersection = (segmentation.labels == label) & (whole == true_label)
        assert (
            intersection.sum()
            > 0.95 * ((segmentation.labels == label) | (whole == true_label)).sum()
        )


def test_inside_is_separate_object_without_join_open():
    frame, _ = solid_frame(VESSEL, (Plate(),))
    assert segment(frame, SegmentationOptions(join_open=False)).count == 2

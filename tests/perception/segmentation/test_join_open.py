"""A vessel's inside belongs to its outside, with its floor, but not what lies in or beside it."""

import numpy as np
import pytest
from solids import Ball, Bowl, Box, Plate, Solid, exact_image, heights, solid_frame

from eyehand.perception import SegmentationOptions, segment
from eyehand.perception.segmentation.join_open import join_open
from eyehand.perception.segmentation.local_planes import fit_local_planes
from eyehand.perception.segmentation.regions import number_by_size

OPTIONS = SegmentationOptions().scaled(320)
BOWL = Bowl(0.0, 0.65, 0.12, 0.12, 0.11)
VESSEL: list[Solid] = [BOWL, BOWL.inside()]
BALL = Ball(0.0, 0.65, 0.045, 0.035)


def joined(solids, change=lambda labels: labels):
    """Labels of exact surfaces before and after."""
    frame, labels = solid_frame(solids, (Plate(),))
    labels = change(labels)
    image = exact_image(frame)
    return labels, join_open(labels, image, fit_local_planes(image, OPTIONS))


def test_the_inside_joins_the_outside():
    labels, whole = joined(VESSEL)
    assert np.array_equal(whole, np.minimum(labels, 1))


def test_its_floor_which_is_too_close_to_the_table_to_stand_out_joins_too():
    frame, truth = solid_frame(VESSEL, (Plate(),))
    height = heights(frame)
    low = (truth == 2) & (height < 0.02)
    assert np.count_nonzero(low) > 100
    _, whole = joined(VESSEL, lambda labels: np.where(low, 0, labels).astype(np.int32))
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
def test_what_lies_in_or_beside_a_bowl_stays_itself(other):
    labels, whole = joined([*VESSEL, other])
    assert np.array_equal(whole, number_by_size(np.where(labels == 2, 1, labels)))


def test_concave_neighbours_are_no_vessel():
    solids: list[Solid] = [Box(0.0, 0.8, (0.3, 0.05, 0.2)), Box(0.0, 0.7, (0.3, 0.15, 0.05))]
    labels, same = joined(solids)
    assert np.array_equal(same, labels)


def test_an_inside_alone_has_no_outside_to_join():
    labels, same = joined([BOWL.inside()])
    assert np.array_equal(same, labels)


@pytest.mark.parametrize(("inside", "count"), [([], 1), ([BALL], 2)])
def test_a_bowl_is_one_object_and_a_ball_in_it_another(inside, count):
    frame, truth = solid_frame([*VESSEL, *inside], (Plate(),))
    found = segment(frame)
    assert found.count == count
    whole = np.where(truth == 2, 1, truth)
    for label, mine in enumerate((1, 3)[:count], start=1):
        both = (found.labels == label) & (whole == mine)
        assert both.sum() > 0.95 * ((found.labels == label) | (whole == mine)).sum()


def test_without_the_stage_the_inside_is_an_object_of_its_own():
    frame, _ = solid_frame(VESSEL, (Plate(),))
    assert segment(frame, SegmentationOptions(join_open=False)).count == 2

"""Which of several contacts is taken."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import FeatureOptions, TactileArray, TactileImage, contact_features

PAD = TactileArray.flat()


def image(*blocks: tuple[int, int, int, int], pressure=(500.0, 500.0)) -> TactileImage:
    """Blocks of (row, column, height, width)."""
    felt = np.zeros((16, 16))
    for (row, column, height, width), value in zip(blocks, pressure, strict=False):
        felt[row : row + height, column : column + width] = value
    return TactileImage(felt.ravel(), PAD)


def column_of(found) -> float:
    return found.centre[0] / 0.005 + 7.5


def test_of_two_regions_the_larger_one_wins_and_of_equal_ones_the_stronger():
    assert column_of(contact_features(image((2, 2, 2, 2), (8, 10, 3, 3)), 10.0)) == 11.0
    equal = image((2, 2, 3, 3), (8, 10, 3, 3), pressure=(500.0, 600.0))
    assert column_of(contact_features(equal, 10.0)) == 11.0


def test_two_contacts_that_take_turns_in_being_larger_do_not_make_the_centre_jump():
    left, right = (4, 2, 3, 3), (4, 10, 3, 3)
    images = [image((4, 2, 3, 4), right), image(left, (4, 10, 3, 4))] * 3
    held, jumping, last = [], [], None
    for each in images:
        last = contact_features(each, 10.0, previous=last, options=FeatureOptions(hysteresis=0.3))
        held.append(column_of(last))
        jumping.append(column_of(contact_features(each, 10.0)))
    assert np.ptp(held) <= 0.5
    assert np.ptp(jumping) > 7


def test_a_region_that_is_clearly_larger_is_taken_all_the_same():
    before = contact_features(image((4, 2, 3, 3)), 10.0)
    now = image((4, 2, 3, 3), (4, 10, 5, 5))
    assert column_of(contact_features(now, 10.0, previous=before)) == 12.0


def test_hysteresis_0_is_the_largest_region_whatever_was_before():
    before = contact_features(image((4, 2, 3, 3)), 10.0)
    now = image((4, 2, 3, 3), (4, 10, 3, 4))
    options = FeatureOptions(hysteresis=0.0)
    assert column_of(contact_features(now, 10.0, previous=before, options=options)) == 11.5


def test_regions_with_too_few_tactels_are_no_contact():
    options = FeatureOptions(min_tactels=3)
    assert not contact_features(image((2, 2, 1, 2)), 10.0, options=options)
    assert contact_features(image((2, 2, 1, 3)), 10.0, options=options)


@given(st.integers(0, 255), st.integers(0, 255))
def test_two_touched_tactels_are_one_region_exactly_when_they_are_neighbours(a, b):
    felt = np.zeros(256)
    felt[[a, b]] = 100.0
    together = PAD.neighbours[a, b] and a != b
    assert contact_features(TactileImage(felt, PAD), 1.0).tactels == 1 + together


@pytest.mark.parametrize(
    "wrong",
    [
        {"sigmas": 0.0},
        {"sigmas": float("nan")},
        {"min_tactels": 0},
        {"hysteresis": 1.5},
        {"orientation": "guess"},
    ],
)
def test_impossible_options_are_refused(wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        FeatureOptions(**wrong)


def test_thresholds_must_fit_the_array():
    with pytest.raises(InputError, match="256"):
        contact_features(image((2, 2, 2, 2)), np.zeros(3))

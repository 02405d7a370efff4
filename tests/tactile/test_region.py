"""The selection of one contact region among several."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import FeatureOptions, TactileArray, TactileImage, contact_features

PAD = TactileArray.flat()


def image(*blocks: tuple[int, int, int, int], pressure=(500.0, 500.0)) -> TactileImage:
    """Return an image with blocks of pressure, each (row, column, height, width) in tactels."""
    pressures = np.zeros((16, 16))
    for (row, column, height, width), value in zip(blocks, pressure, strict=False):
        pressures[row : row + height, column : column + width] = value
    return TactileImage(pressures.ravel(), PAD)


def centre_column(found) -> float:
    return found.centre[0] / 0.005 + 7.5


def test_largest_region_is_selected_and_force_breaks_ties():
    assert centre_column(contact_features(image((2, 2, 2, 2), (8, 10, 3, 3)), 10.0)) == 11.0
    equal = image((2, 2, 3, 3), (8, 10, 3, 3), pressure=(500.0, 600.0))
    assert centre_column(contact_features(equal, 10.0)) == 11.0


def test_hysteresis_keeps_centre_steady_when_region_sizes_alternate():
    left, right = (4, 2, 3, 3), (4, 10, 3, 3)
    images = [image((4, 2, 3, 4), right), image(left, (4, 10, 3, 4))] * 3
    held, jumping, last = [], [], None
    for each in images:
        last = contact_features(each, 10.0, previous=last, options=FeatureOptions(hysteresis=0.3))
        held.append(centre_column(last))
        jumping.append(centre_column(contact_features(each, 10.0)))
    assert np.ptp(held) <= 0.5
    assert np.ptp(jumping) > 7


def test_clearly_larger_region_replaces_tracked_region():
    before = contact_features(image((4, 2, 3, 3)), 10.0)
    now = image((4, 2, 3, 3), (4, 10, 5, 5))
    assert centre_column(contact_features(now, 10.0, previous=before)) == 12.0


def test_without_hysteresis_largest_region_is_selected():
    before = contact_features(image((4, 2, 3, 3)), 10.0)
    now = image((4, 2, 3, 3), (4, 10, 3, 4))
    options = FeatureOptions(hysteresis=0.0)
    assert centre_column(contact_features(now, 10.0, previous=before, options=options)) == 11.5


def test_regions_below_min_tactels_are_ignored():
    options = FeatureOptions(min_tactels=3)
    assert not contact_features(image((2, 2, 1, 2)), 10.0, options=options)
    assert contact_features(image((2, 2, 1, 3)), 10.0, options=options)


@given(st.integers(0, 255), st.integers(0, 255))
def test_two_active_tactels_form_one_region_only_as_neighbours(a, b):
    pressures = np.zeros(256)
    pressures[[a, b]] = 100.0
    together = [min(a, b), max(a, b)] in PAD.neighbours.tolist()
    assert contact_features(TactileImage(pressures, PAD), 1.0).tactels == 1 + together


@pytest.mark.parametrize(
    "fields",
    [
        {"sigmas": 0.0},
        {"sigmas": float("nan")},
        {"min_tactels": 0},
        {"hysteresis": 1.5},
        {"orientation": "guess"},
    ],
)
def test_feature_options_reject_invalid_values(fields):
    with pytest.raises(InputError, match=next(iter(fields))):
        FeatureOptions(**fields)


def test_contact_features_reject_mismatched_thresholds():
    with pytest.raises(InputError, match="256"):
        contact_features(image((2, 2, 2, 2)), np.zeros(3))

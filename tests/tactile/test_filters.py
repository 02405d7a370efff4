"""Moving averages, of values and of directions without a sense."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import ContactFeatures, FeatureFilter, MovingAngle, MovingAverage


def features(force=1.0, orientation=0.0, confidence=1.0) -> ContactFeatures:
    return ContactFeatures(force, np.zeros(3), 2 * force, 0.5, orientation, confidence)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40), st.integers(1, 12))
def test_the_average_is_that_of_the_last_values(values, length):
    average = MovingAverage(length)
    means = [average.step(value) for value in values]
    assert means[-1] == pytest.approx(np.mean(values[-length:]), abs=1e-6)


def test_90_degrees_from_both_sides_average_to_90_and_not_to_0():
    angle = MovingAngle(2)
    angle.step(np.radians(89.0))
    mean, confidence = angle.step(np.radians(-89.0))
    assert mean == pytest.approx(np.pi / 2)
    assert confidence == pytest.approx(np.cos(np.radians(2.0)))


@given(st.floats(-1.5, 1.5), st.lists(st.floats(-0.3, 0.3), min_size=1, max_size=10))
def test_the_mean_turns_with_the_angles(turn, spread):
    plain, turned = MovingAngle(10), MovingAngle(10)
    mean, confidence = [plain.step(angle) for angle in spread][-1]
    mean_turned, confidence_turned = [turned.step(angle + turn) for angle in spread][-1]
    gap = (mean_turned - mean - turn + np.pi / 2) % np.pi - np.pi / 2
    assert gap == pytest.approx(0.0, abs=1e-9)
    assert confidence_turned == pytest.approx(confidence)
    assert -np.pi / 2 < mean_turned <= np.pi / 2


def test_angles_without_confidence_do_not_count_and_the_last_mean_stays():
    angle = MovingAngle(3)
    angle.step(0.4)
    assert angle.step(-1.2, confidence=0.0)[0] == pytest.approx(0.4)
    held = [angle.step(1.1, confidence=0.0) for _ in range(4)]
    assert held[-1] == (pytest.approx(0.4), 0.0)


def test_angles_that_disagree_say_so():
    angle = MovingAngle(2)
    angle.step(0.0)
    assert angle.step(np.pi / 2)[1] == pytest.approx(0.0, abs=1e-12)


def test_features_are_averaged_until_contact_is_lost():
    average = FeatureFilter(4)
    average.step(features(force=1.0, orientation=np.pi / 2))
    found = average.step(features(force=3.0, orientation=-np.pi / 2 + 0.02))
    assert found.force == 2.0
    assert found.pressure == 4.0
    assert abs(found.orientation) == pytest.approx(np.pi / 2 - 0.01)
    assert not average.step(features(force=0.0))
    assert average.step(features(force=5.0)).force == 5.0


def test_impossible_lengths_and_values_are_refused():
    with pytest.raises(InputError, match="length"):
        MovingAverage(0)
    with pytest.raises(InputError, match="finite"):
        MovingAverage().step(float("nan"))
    with pytest.raises(InputError, match="confidence"):
        MovingAngle().step(0.0, 1.5)

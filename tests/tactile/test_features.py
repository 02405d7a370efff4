"""Contact features of synthetic contacts with known position, direction and force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import TactileArray, TactileImage, contact_features

PAD = TactileArray.flat()


def blob(x, y, angle=0.0, long=0.012, short=0.004, peak=1000.0) -> np.ndarray:
    dx, dy = PAD.positions[:, 0] - x, PAD.positions[:, 1] - y
    along, across = (
        np.cos(angle) * dx + np.sin(angle) * dy,
        -np.sin(angle) * dx + np.cos(angle) * dy,
    )
    return peak * np.exp(-0.5 * ((along / long) ** 2 + (across / short) ** 2))


@given(x=st.floats(-0.015, 0.015), y=st.floats(-0.015, 0.015))
def test_centre_of_round_contact_has_subtactel_accuracy(x, y):
    found = contact_features(TactileImage(blob(x, y, long=0.006, short=0.006), PAD), 1.0)
    assert np.allclose(found.centre, [x, y, 0.0], atol=2e-4)
    assert found.confidence < 0.1


@given(angle=st.floats(-1.55, 1.55))
def test_orientation_of_elongated_contact_is_modulo_pi(angle):
    found = contact_features(TactileImage(blob(0.0, 0.0, angle), PAD), 1.0)
    gap = (found.orientation - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(gap) < np.radians(3)
    assert found.confidence > 0.6
    assert -np.pi / 2 < found.orientation <= np.pi / 2


def test_force_is_summed_over_largest_region_only():
    pressures = np.zeros(256)
    pressures[[0, 1, 16, 17]] = 500.0
    pressures[255] = 5000.0
    found = contact_features(TactileImage(pressures, PAD), 10.0)
    assert found.force == pytest.approx(4 * 500.0 * 0.005**2)
    assert found.area == pytest.approx(4 * 0.005**2)
    assert found.pressure == pytest.approx(500.0)
    assert np.allclose(found.centre[:2], PAD.positions[[0, 1, 16, 17], :2].mean(axis=0))


def test_features_without_contact_are_false_and_finite():
    found = contact_features(TactileImage(np.zeros(256), PAD), 1.0)
    assert not found
    assert found.force == 0.0
    assert np.all(np.isfinite(found.centre))


@pytest.mark.parametrize("threshold", [-1.0, float("nan"), float("inf")])
def test_contact_features_reject_invalid_threshold(threshold):
    with pytest.raises(InputError, match="threshold"):
        contact_features(TactileImage(np.zeros(256), PAD), threshold)


def test_image_and_array_reject_invalid_shapes():
    with pytest.raises(InputError, match="256"):
        TactileImage(np.zeros(16), PAD)
    with pytest.raises(InputError, match="pitch"):
        TactileArray.flat(pitch=0.0)

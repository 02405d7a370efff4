"""The direction of a line by the Hough transform of the paper."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.tactile import (
    FeatureOptions,
    HoughOptions,
    TactileArray,
    TactileImage,
    contact_features,
    hough_axis,
)

PAD = TactileArray.flat()
WHOLE_PAD = np.ones(256, bool)


def line(angle: float) -> TactileImage:
    x, y = PAD.positions[:, 0], PAD.positions[:, 1]
    across = -np.sin(angle) * x + np.cos(angle) * y
    return TactileImage(1000.0 * np.exp(-0.5 * (across / 0.003) ** 2), PAD)


@given(st.floats(-1.57, 1.57))
def test_hough_axis_is_accurate_to_10_degrees(angle):
    gap = (hough_axis(line(angle), WHOLE_PAD) - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(gap) < np.radians(10.0)


@pytest.mark.parametrize("angle", [0.0, np.pi / 4, np.pi / 2, -np.pi / 4])
def test_hough_axis_is_exact_along_grid_directions(angle):
    found = hough_axis(line(angle), WHOLE_PAD, HoughOptions(angles=180, share=0.9))
    assert found == pytest.approx(angle, abs=np.radians(1.0))
    assert -np.pi / 2 < found <= np.pi / 2


def test_hough_orientation_is_optional_and_zero_for_empty_region():
    options = FeatureOptions(orientation="hough")
    assert contact_features(line(0.0), 10.0, options=options).orientation == pytest.approx(0.0)
    assert hough_axis(line(0.3), np.zeros(256, bool)) == 0.0


def test_hough_axis_rejects_gridless_array_and_invalid_options():
    tip = TactileArray.fingertip()
    with pytest.raises(InputError, match="grid"):
        hough_axis(TactileImage(np.ones(12), tip), np.ones(12, bool))
    with pytest.raises(InputError, match="angles"):
        HoughOptions(angles=1)
    with pytest.raises(InputError, match="share"):
        HoughOptions(share=1.0)

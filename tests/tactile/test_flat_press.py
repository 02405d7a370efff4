"""Gains of tactels from a press of a flat plate."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile import TactileArray, calibrate, flat_press_gains

from .synthetic_pad import SyntheticPad

ARRAY = TactileArray.flat(16, 16)
X, Y = (ARRAY.positions[:, :2] / 0.04).T
PLATE = 800.0 * np.exp(0.2 * X - 0.1 * Y + 0.1 * X * Y - 0.3 * X**6 - 0.2 * Y**4)
"""Pressures under a tilted plate that falls towards the rim, Pa."""
TRUE = np.exp(0.1 * np.random.default_rng(0).standard_normal(256))


def test_gains_are_found_up_to_the_share_that_the_surface_follows():
    noise = np.random.default_rng(1).normal(0.0, 5.0, (50, 256))
    found = flat_press_gains(ARRAY, PLATE * TRUE + noise)
    # 10 terms of 256 tactels follow sqrt(10 / 256) = 20 % of the spread of 0.1.
    assert np.std(np.log(found / TRUE)) < 0.025
    assert np.log(found).mean() == pytest.approx(0.0, abs=1e-9)
    assert flat_press_gains(ARRAY, PLATE[None]) == pytest.approx(np.ones(256))
    one = np.where(np.arange(256) == 100, 1.3, 1.0)
    assert flat_press_gains(ARRAY, (PLATE * one)[None])[100] == pytest.approx(1.3, rel=0.01)


@pytest.mark.parametrize("broken", [0.0, 12e3])
def test_broken_tactel_has_no_gain_and_changes_no_other(broken):
    press = PLATE.copy()
    press[[7, 100]] = broken
    assert flat_press_gains(ARRAY, press[None]) == pytest.approx(np.ones(256))


@pytest.mark.parametrize(
    ("array", "images", "message"),
    [
        (ARRAY, np.zeros((5, 256)), "median of 100 Pa, got 0"),
        (ARRAY, np.full((5, 256), np.nan), "finite"),
        (ARRAY, PLATE, "must be"),
        (ARRAY, PLATE[None, :64], "must be"),
        (ARRAY, np.zeros((0, 256)), "must be"),
        (ARRAY, (PLATE * (X > -0.5))[None], "at least 230 tactels"),
        (TactileArray.flat(4, 6), np.full((5, 24), 800.0), "at least 40 tactels"),
        (TactileArray.curved(), PLATE[None], "flat pad"),
    ],
)
def test_what_is_no_flat_press_is_refused(array, images, message):
    with pytest.raises(InputError, match=message):
        flat_press_gains(array, images)


def test_calibration_divides_by_gains():
    calibration = calibrate(SyntheticPad.draw().bench())
    raw = np.full(256, 1500, np.uint16)
    corrected = calibration.with_gains(TRUE)
    assert corrected.to_pressure(raw) == pytest.approx(calibration.to_pressure(raw) / TRUE)
    for gains in (TRUE[:4], -TRUE, np.full(256, np.nan)):
        with pytest.raises(InputError, match="256 values > 0"):
            calibration.with_gains(gains)

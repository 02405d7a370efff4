"""A pad that is commissioned by one press."""

import numpy as np
import pytest

from eyehand.apps.touch.arm_rig import CYCLE, RigOptions
from eyehand.apps.touch.commissioning import commissioned, press_timing, pressed_gains
from eyehand.data_synth.pad import SENSORS


@pytest.mark.parametrize("sensor", ["good", "real"])
def test_press_shows_delay_and_lag(sensor):
    timing, rig = press_timing(sensor), RigOptions()
    true = rig.latency * CYCLE + SENSORS[sensor].wait + rig.lag
    assert timing.latency * CYCLE + timing.lag == pytest.approx(true, abs=0.005)
    assert timing.residual < 0.1
    assert commissioned(sensor).latency == timing.latency


def test_only_sheared_foam_has_a_lever():
    assert commissioned("good").shear_lever == 0.0
    assert commissioned("real").shear_lever > 0.0


def test_flat_press_shows_the_spread_of_the_gains():
    for sensor in ("good", "real"):
        gains = pressed_gains(sensor, 1)
        assert gains is not None
        assert np.log(gains).std() == pytest.approx(SENSORS[sensor].gain_spread, abs=0.02)
    assert pressed_gains("ideal", 1) is None

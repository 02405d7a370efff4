"""The limit of the loop gain against loops that are played through."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile.gain_limit import gain_limit
from eyehand.tactile.servo_options import ServoOptions

CASES = [(1, 0.0, 1), (1, 0.015, 1), (6, 0.015, 1), (10, 0.0, 1), (10, 0.02, 2), (4, 0.01, 0)]


@pytest.mark.parametrize(("window", "lag", "latency"), CASES)
def test_a_loop_settles_below_the_limit_and_grows_above(window, lag, latency):
    limit = gain_limit(window, 250.0, lag, latency)
    assert _late_over_early(0.85 * limit, window, lag, latency) < 0.5
    assert _late_over_early(1.15 * limit, window, lag, latency) > 2.0


def test_the_known_limits_of_a_ten_sample_filter_at_250_hz_contain_it():
    assert 71.0 < gain_limit(10, 250.0, 0.0, 1) < 138.0
    assert 107.0 < gain_limit(1, 250.0, 0.0, 1) < 421.0


def test_filter_lag_and_wait_all_cost_gain_and_the_default_stays_far_below():
    assert gain_limit(10, 250.0, 0.015, 1) < gain_limit(4, 250.0, 0.015, 1)
    assert gain_limit(4, 250.0, 0.03, 1) < gain_limit(4, 250.0, 0.015, 1)
    assert gain_limit(4, 250.0, 0.015, 3) < gain_limit(4, 250.0, 0.015, 1)
    for window in (1, 6, 10, 40):
        options = ServoOptions(window=window)
        assert options.press_loop_gain() <= 0.25 * options.press_limit()


def test_impossible_loops_are_refused():
    for wrong in ((0, 250.0, 0.01, 1), (5, 0.0, 0.01, 1), (5, 250.0, -0.1, 1)):
        with pytest.raises(InputError, match="gain limit"):
            gain_limit(*wrong)


def _late_over_early(gain, window, lag, latency):
    dt, place, velocity = 0.004, 1.0, 0.0
    readings, commands = [1.0] * window, [0.0] * latency
    share = 1.0 - np.exp(-dt / lag) if lag > 0 else 1.0
    seen = []
    for _ in range(750):
        readings.append(place)
        commands.append(-gain * float(np.mean(readings[-window:])))
        before = velocity
        velocity += share * (commands[-1 - latency] - velocity)
        # The velocity moves exponentially within the cycle; its mean moves the place.
        mean = commands[-1 - latency] + (before - commands[-1 - latency]) * (
            share * lag / dt if lag > 0 else 0.0
        )
        place += mean * dt
        seen.append(abs(place))
    return max(seen[-150:]) / max(seen[:150])

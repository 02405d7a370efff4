"""The limit of the loop gain against simulated loops."""

import numpy as np
import pytest

from eyehand.errors import InputError
from eyehand.tactile.servo_options import ServoOptions, gain_limit

CASES = [(1, 0.0, 1), (1, 0.015, 1), (6, 0.015, 1), (10, 0.0, 1), (10, 0.02, 2), (4, 0.01, 0)]


@pytest.mark.parametrize(("window", "lag", "latency"), CASES)
def test_loop_is_stable_below_limit_and_unstable_above(window, lag, latency):
    limit = gain_limit(window, 250.0, lag, latency)
    assert _amplitude_ratio(0.85 * limit, window, lag, latency) < 0.5
    assert _amplitude_ratio(1.15 * limit, window, lag, latency) > 2.0


def test_gain_limit_lies_in_known_range_for_filter_at_250_hz():
    assert 71.0 < gain_limit(10, 250.0, 0.0, 1) < 138.0
    assert 107.0 < gain_limit(1, 250.0, 0.0, 1) < 421.0


def test_filter_lag_and_latency_reduce_limit_and_default_gain_is_below():
    assert gain_limit(10, 250.0, 0.015, 1) < gain_limit(4, 250.0, 0.015, 1)
    assert gain_limit(4, 250.0, 0.03, 1) < gain_limit(4, 250.0, 0.015, 1)
    assert gain_limit(4, 250.0, 0.015, 3) < gain_limit(4, 250.0, 0.015, 1)
    for window in (1, 6, 10, 40):
        options = ServoOptions(window=window)
        limit = gain_limit(window, options.rate, options.arm_lag, options.latency)
        assert options.press_loop_gain() <= 0.25 * limit


def test_gain_limit_rejects_invalid_loops():
    for invalid in ((0, 250.0, 0.01, 1), (5, 0.0, 0.01, 1), (5, 250.0, -0.1, 1)):
        with pytest.raises(InputError, match="gain limit"):
            gain_limit(*invalid)


def _amplitude_ratio(gain, window, lag, latency):
    dt, position, velocity = 0.004, 1.0, 0.0
    readings, commands = [1.0] * window, [0.0] * latency
    share = 1.0 - np.exp(-dt / lag) if lag > 0 else 1.0
    amplitudes = []
    for _ in range(750):
        readings.append(position)
        commands.append(-gain * float(np.mean(readings[-window:])))
        last_velocity = velocity
        velocity += share * (commands[-1 - latency] - velocity)
        # The velocity follows an exponential within the cycle. Its mean moves the position.
        mean = commands[-1 - latency] + (last_velocity - commands[-1 - latency]) * (
            share * lag / dt if lag > 0 else 0.0
        )
        position += mean * dt
        amplitudes.append(abs(position))
    return max(amplitudes[-150:]) / max(amplitudes[:150])

"""Delay of an arm behind its commands."""

import numpy as np
import pytest

from eyehand.grasping.follow_delay import MAX_DELAY, FollowDelay

PERIOD = 0.004


@pytest.mark.parametrize("scale", [1.0, 0.5])
@pytest.mark.parametrize("late", [0, 5, 20, 40])
def test_delay_is_that_between_command_and_motion(late, scale):
    """Some arms scale all speeds; angles have a noise of 0.1 mrad."""
    rng, delay = np.random.default_rng(late), FollowDelay()
    commands = [np.zeros(3)] * 100
    q = np.zeros(3)
    for k in range(400):
        commands.append(min(3.75 * k * PERIOD, 1.2) * np.array([1.0, -0.4, 0.1]))
        q = q + scale * PERIOD * commands[-1 - late]
        delay.add(q + rng.normal(0.0, 1e-4, 3), commands[-1], PERIOD)
    assert delay.known
    assert delay.seconds == pytest.approx(late * PERIOD)


def test_short_motion_gives_no_delay():
    delay = FollowDelay()
    for k in range(400):
        delay.add(np.full(3, 1e-4 * k), np.full(3, 0.025), PERIOD)
    assert not delay.known
    assert delay.seconds == MAX_DELAY

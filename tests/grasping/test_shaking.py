"""The shake of the hand: its acceleration, and its rest at both ends."""

from __future__ import annotations

import numpy as np
import pytest

from eyehand.grasping.shaking import PEAK_ACCELERATION, shake

from .test_pick_state import cell, pick_state

__all__ = ["cell"]


@pytest.mark.parametrize("seconds", [0.7, 1.0, 2.0])
def test_shake_keeps_its_acceleration_and_ends_at_rest(cell, seconds):
    speeds = [np.zeros(3)]
    step = cell.robot.step

    def recorded(velocity, command=None):
        speeds.append((cell.arm_state().jacobian @ velocity)[:3])
        return step(velocity, command)

    cell.robot.step = recorded
    shake(cell, pick_state("precision"), seconds)
    change = np.diff(speeds, axis=0) / cell.robot.period
    largest = np.abs(change).max(axis=0)
    assert (largest < 1.05 * PEAK_ACCELERATION).all()
    assert (largest > 0.8 * PEAK_ACCELERATION).all()
    last = PEAK_ACCELERATION * cell.robot.period
    assert np.abs(speeds[-1]).max() < 1.05 * last

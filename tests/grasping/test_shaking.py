"""The shake of the hand: its acceleration, and its rest at both ends."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from eyehand.grasping import shaking
from eyehand.grasping.shaking import PEAK_ACCELERATION, shake, shake_off

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


@pytest.mark.parametrize(("weight", "hanging"), [(0.02, ""), (0.3, "thumb_distal")])
def test_a_loaded_pad_counts_only_if_the_wrist_feels_a_load(monkeypatch, weight, hanging):
    reading = SimpleNamespace(hand=None, wrench=np.array([0.0, 1.0, weight, 0.0, 0.0, 0.0]))
    hand = SimpleNamespace(contacts=lambda *_: ("thumb_distal",))
    cell: Any = SimpleNamespace(reading=reading, hand=hand, wait=lambda _, note: note(reading))
    state: Any = SimpleNamespace(tare=np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]), closing=None)
    shakes = []
    monkeypatch.setattr(shaking, "shake", lambda *_: shakes.append(1))
    assert shake_off(cell, state) == hanging
    assert len(shakes) == bool(hanging)

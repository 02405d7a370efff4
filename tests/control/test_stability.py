"""The stress sweeps of the motion: each bound holds, and failures beyond it are clean."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.motion import gain_sweeps, goal_sweeps
from eyehand.apps.motion.stress import control_sweeps
from eyehand.apps.motion.stress_trial import MotionFigures
from eyehand.control.options import ControlOptions

SWEEPS = {sweep.name: sweep for sweep in control_sweeps()}
SEED = 100
"""A seed that was not used to select scenes or bounds."""


@pytest.fixture(autouse=True)
def shorten_sweeps(monkeypatch):
    """Shorten the sweeps: 45 s in place of 60 s still contain two retreats and a standstill."""
    monkeypatch.setattr(goal_sweeps, "LONG_S", 45.0)
    monkeypatch.setattr(gain_sweeps, "STEPS", 500)


@pytest.mark.parametrize("name", [name for name, sweep in SWEEPS.items() if sweep.holds_to])
def test_sweep_passes_at_its_bound(name):
    sweep = SWEEPS[name]
    trial = sweep.attempt(sweep.required_values()[-1], SEED, ControlOptions())
    assert trial.clean, trial.note
    assert trial.passed, trial.note


@pytest.mark.parametrize(("name", "value"), [("raw-gain", 2.1), ("flying-ball", 6.4)])
def test_sweep_fails_cleanly_beyond_its_bound(name, value):
    trial = SWEEPS[name].attempt(value, SEED, ControlOptions())
    assert not trial.passed
    assert trial.clean, trial.note


@pytest.mark.parametrize("beyond_mm", [-100.0, -5.0, 5.0, 100.0])
def test_stretched_arm_keeps_speed_limit_and_settles(beyond_mm):
    trial = SWEEPS["out-of-reach"].attempt(beyond_mm, SEED, ControlOptions())
    assert trial.passed, trial.note
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.peak_speed_pct is not None
    assert trial.picture.peak_speed_pct <= 100.0001
    assert trial.picture.end_step_rad is not None
    assert trial.picture.end_step_rad < 2e-3


def test_oscillation_starts_above_gain_two():
    def amplitude(gain):
        trial = SWEEPS["raw-gain"].attempt(gain, SEED, ControlOptions())
        assert isinstance(trial.picture, MotionFigures)
        assert trial.picture.amplitude_mm is not None
        return trial.picture.amplitude_mm

    assert amplitude(1.9) < 0.01
    amplitudes = [amplitude(gain) for gain in (2.1, 2.5, 3.0)]
    assert amplitudes[0] > 0.3
    assert np.all(np.diff(amplitudes) > 0)


@pytest.mark.parametrize("depth_mm", [1.0, 10.0, 80.0])
def test_penetration_is_resolved_without_going_deeper(depth_mm):
    trial = SWEEPS["penetration"].attempt(depth_mm, SEED, ControlOptions())
    assert trial.passed, trial.note
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.closest_mm == pytest.approx(-depth_mm, abs=0.5)


def test_alternating_weights_keep_acceleration_limit():
    for cycles in (200.0, 1.0):
        trial = SWEEPS["switching"].attempt(cycles, SEED, ControlOptions())
        assert trial.passed, trial.note
        assert isinstance(trial.picture, MotionFigures)
        assert trial.picture.peak_acceleration is not None
        assert trial.picture.peak_acceleration <= 15.0 + 1e-9


def test_goal_in_obstacle_causes_contact_without_safety_level():
    # This test shows that the safety level is what prevents the contact above.
    options = replace(ControlOptions(), safety=False, beta=0.0, retreats=0)
    trial = SWEEPS["inside-obstacle"].attempt(60.0, SEED, options)
    assert not trial.passed
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.closest_mm is not None
    assert trial.picture.closest_mm < 0.0

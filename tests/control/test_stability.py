"""What the control basis holds to at each stress sweep's bound, and where it must break."""

from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.motion import gain_sweeps, goal_sweeps
from eyehand.apps.motion.stress import control_sweeps
from eyehand.apps.motion.stress_trial import MotionFigures
from eyehand.control.options import ControlOptions

SWEEPS = {sweep.name: sweep for sweep in control_sweeps()}
SEED = 100
"""Not among those that scenes and bounds were chosen on."""


@pytest.fixture(autouse=True)
def shorter(monkeypatch):
    """The command simulates 60 s before an obstacle; 45 s are two retreats and some standing."""
    monkeypatch.setattr(goal_sweeps, "LONG_S", 45.0)
    monkeypatch.setattr(gain_sweeps, "STEPS", 500)


@pytest.mark.parametrize("name", [name for name, sweep in SWEEPS.items() if sweep.holds_to])
def test_bound_holds(name):
    sweep = SWEEPS[name]
    trial = sweep.attempt(sweep.required_values()[-1], SEED, ControlOptions())
    assert trial.clean, trial.note
    assert trial.passed, trial.note


@pytest.mark.parametrize(
    ("name", "value"),
    [("raw-gain", 2.1), ("parallel-plain", 0.002), ("flying-ball", 6.4)],
)
def test_breaks_cleanly_where_it_must(name, value):
    trial = SWEEPS[name].attempt(value, SEED, ControlOptions())
    assert not trial.passed
    assert trial.clean, trial.note


@pytest.mark.parametrize("beyond_mm", [-100.0, -5.0, 5.0, 100.0])
def test_stretched_arm_is_slow_enough_and_settles(beyond_mm):
    trial = SWEEPS["out-of-reach"].attempt(beyond_mm, SEED, ControlOptions())
    assert trial.passed, trial.note
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.peak_speed_pct is not None
    assert trial.picture.peak_speed_pct <= 100.0001
    assert trial.picture.end_step_rad is not None
    assert trial.picture.end_step_rad < 2e-3


def test_oscillation_starts_at_gain_two():
    def amplitude(gain):
        trial = SWEEPS["raw-gain"].attempt(gain, SEED, ControlOptions())
        assert isinstance(trial.picture, MotionFigures)
        assert trial.picture.amplitude_mm is not None
        return trial.picture.amplitude_mm

    assert amplitude(1.9) < 0.01
    swings = [amplitude(gain) for gain in (2.1, 2.5, 3.0)]
    assert swings[0] > 0.3
    assert np.all(np.diff(swings) > 0)


@pytest.mark.parametrize("depth_mm", [1.0, 10.0, 80.0])
def test_penetration_ends_outside_and_never_deeper(depth_mm):
    trial = SWEEPS["penetration"].attempt(depth_mm, SEED, ControlOptions())
    assert trial.passed, trial.note
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.closest_mm == pytest.approx(-depth_mm, abs=0.5)


def test_weights_in_turns_are_felt_and_bounded():
    peaks = []
    for cycles in (200.0, 1.0):
        trial = SWEEPS["switching"].attempt(cycles, SEED, ControlOptions())
        assert trial.passed, trial.note
        assert isinstance(trial.picture, MotionFigures)
        peaks.append(trial.picture.peak_acceleration)
    # A single weight alone needs some 2 rad/s².
    assert peaks[0] > peaks[1] + 20 > 40


def test_cover_makes_the_gradient_smooth():
    jumps = {}
    for name in ("parallel-cover", "parallel-plain"):
        picture = SWEEPS[name].attempt(0.002, SEED, ControlOptions()).picture
        assert isinstance(picture, MotionFigures)
        jumps[name] = picture.jump_pct
    assert jumps["parallel-cover"] < 1.0
    assert jumps["parallel-plain"] > 5.0


def test_without_the_safety_level_a_goal_in_an_obstacle_is_touched():
    # The bound above is worth something only if the level is what keeps it.
    options = replace(ControlOptions(), safety=False, beta=0.0, retreats=0)
    trial = SWEEPS["inside-obstacle"].attempt(60.0, SEED, options)
    assert not trial.passed
    assert isinstance(trial.picture, MotionFigures)
    assert trial.picture.closest_mm is not None
    assert trial.picture.closest_mm < 0.0

"""Picks whose sense of touch fails end in a named outcome, with the hand off the object."""

import pytest

from eyehand.apps.bench.sweep import select_sweeps
from eyehand.apps.grasp.bench.stress import grasp_sweeps
from eyehand.grasping import PickOptions


@pytest.mark.parametrize(
    ("name", "phase"), [("touch-repeats", 5.0), ("touch-tactels", 7.0), ("touch-forces", 2.0)]
)
def test_failed_touch_ends_the_pick_with_the_hand_off_the_object(name, phase):
    (sweep,) = select_sweeps(grasp_sweeps(), (name,))
    trial = sweep.attempt(phase, 0, PickOptions())
    assert trial.passed, trial.note
    assert trial.clean


@pytest.mark.slow
@pytest.mark.parametrize("name", ["touch-repeats", "touch-tactels", "touch-forces"])
def test_touch_may_fail_in_any_phase(name):
    (sweep,) = select_sweeps(grasp_sweeps(), (name,))
    for phase in sweep.values:
        trial = sweep.attempt(phase, 0, PickOptions())
        assert trial.passed, (phase, trial.note)

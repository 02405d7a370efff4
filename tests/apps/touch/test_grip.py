"""Grip laws in simulated trials, and the command."""

import json

import numpy as np
import pytest

from eyehand.apps.touch.grip_trials import GRAVITY, LAWS, draw_grip_trial, run_law
from eyehand.data_synth.pad import SENSORS
from eyehand.tactile import SlipScore

NEVER = SlipScore(lambda features: np.zeros(len(features)), 1.0)
ALWAYS = SlipScore(lambda features: np.ones(len(features)), 0.5)


def test_trial_loads_the_object_by_its_weight_at_first():
    trial = draw_grip_trial(0)
    assert trial.load(-0.1) == pytest.approx([0.0, -trial.held.mass * GRAVITY])
    later = trial.load(trial.start + trial.rise + 0.5)
    assert abs(later[1]) <= trial.held.mass * GRAVITY * (1 + trial.added + trial.shake)


def test_constant_grip_holds_what_it_was_drawn_for():
    result = run_law("constant", draw_grip_trial(1), 1, SENSORS["good"], NEVER)
    assert not result.lost
    assert result.friction is None
    assert result.force_ratio > 2.0


@pytest.mark.parametrize("law", ["pull + wrist", "pull + shear"])
def test_pull_finds_friction_and_holds_with_little_force(law):
    result = run_law(law, draw_grip_trial(1), 1, SENSORS["real"], NEVER)
    assert not result.lost
    assert result.friction == pytest.approx(1.0, abs=0.25)
    assert result.force_ratio < 2.0


@pytest.mark.parametrize("seed", [8002, 8006])
def test_object_that_sticks_until_the_end_of_the_pull_is_not_held_as_if_it_were_slippery(seed):
    """Light objects with much friction; assumed to be slippery, they took ten times the least."""
    result = run_law("pull + wrist", draw_grip_trial(seed), seed, SENSORS["real"], NEVER)
    assert not result.lost
    assert result.force_ratio < 2.5


def test_alarms_of_the_detector_raise_the_grip():
    trial = draw_grip_trial(1)
    calm, alarmed = (
        run_law("chapter", trial, 1, SENSORS["good"], score) for score in (NEVER, ALWAYS)
    )
    assert alarmed.force_ratio > 3 * calm.force_ratio


def test_command_judges_all_laws(tmp_path, run_experiment):
    code, out, _ = run_experiment(
        "grip", "--quick", "--trials", 1, "--json", "--out", tmp_path / "out"
    )
    assert code == 0
    rows = json.loads(out)["rows"]
    assert tuple(row["name"] for row in rows) == LAWS
    bound = rows[-1]
    assert bound["kept_pct"] == 100.0
    assert 1.1 < bound["force_ratio"] < 1.4
    assert all(np.isfinite(row["force_ratio"]) for row in rows)
    assert (tmp_path / "out" / "grip.png").stat().st_size > 10_000

"""`eyehand stress motion`: limits of every motion, files and exit codes."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.bench import StressArguments, Sweep, Trial
from eyehand.apps.motion import stress
from eyehand.apps.motion.stress import control_sweeps, stress_motion
from eyehand.apps.motion.stress_trial import (
    SimulatedMotion,
    find_fault,
    lbr_world,
    motion_trial,
    simulate,
)
from eyehand.control import ControlOptions
from eyehand.control.tasks import Position
from eyehand.errors import InputError


@pytest.fixture(scope="module")
def motion() -> SimulatedMotion:
    world = lbr_world()
    goal = world.robot.at(world.robot.home).position + np.array([0.0, 0.02, 0.0])
    return simulate(world, [Position(goal)], ControlOptions(), 5.0)


def test_motion_is_recorded_completely(motion):
    assert motion.last.status == "reached"
    assert len(motion.postures) == len(motion.cycles) + 1
    steps = np.diff(motion.postures, axis=0)
    assert steps == pytest.approx(motion.dt * motion.velocities, abs=1e-12)
    assert find_fault(motion, ControlOptions()) == ""
    assert motion_trial(motion, ControlOptions(), passed=True).passed


def test_motion_ends_when_it_is_stuck():
    world = lbr_world()
    options = ControlOptions(retreats=0)
    goal = Position(np.array([3.0, 0.0, 0.5]))
    stuck = simulate(world, [goal], options, 60.0, stop_when_stuck=True)
    assert stuck.last.status == "stuck"
    assert len(stuck.cycles) * options.dt < 20.0


def test_faults_are_found(motion):
    options = ControlOptions()
    nan = replace(motion, postures=np.full_like(motion.postures, np.nan))
    assert "finite" in find_fault(nan, options)
    fast = replace(motion, velocities=3.0 * motion.limits * np.ones_like(motion.velocities))
    assert "300" in find_fault(fast, options)
    near = replace(motion, clearance=np.full_like(motion.clearance, options.margin - 1e-3))
    assert "9.00 mm" in find_fault(near, options)
    assert find_fault(near, options, margin=False) == ""
    assert find_fault(near, replace(options, safety=False)) == ""
    mute = replace(motion.last, status="stuck", reason="")
    assert "without a reason" in find_fault(replace(motion, cycles=(mute,)), options)
    assert not motion_trial(near, options, passed=True).clean


def test_sweeps_have_unique_names_and_bounds():
    sweeps = control_sweeps()
    assert len({sweep.name for sweep in sweeps}) == len(sweeps)
    assert sum(sweep.holds_to is not None for sweep in sweeps) >= 10


def test_command_writes_chart_and_one_json_object(tmp_path, capsys):
    code = stress_motion(
        StressArguments(only=["gain", "penetration"], seed=3, quick=True, out=tmp_path, json=True)
    )
    assert code == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "eyehand.stress_motion/2"
    assert report["seed"] == 3
    assert [row["name"] for row in report["rows"]] == ["gain", "penetration"]
    assert report["broken_bounds"] == []
    assert (tmp_path / "stress.png").read_bytes()[:4] == b"\x89PNG"
    with (tmp_path / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["refused_pct"] for row in rows if row["name"] == "gain"] == ["0.0", "100.0"]


def test_broken_bound_gives_exit_code_1_and_is_named(tmp_path, capsys, monkeypatch):
    def attempt(value: float, seed: int, options: ControlOptions) -> Trial:
        return Trial(value < 2, "went astray")

    sweep = Sweep("weak", "load", "kg", (1.0, 2.0), 2.0, attempt, "stays")
    monkeypatch.setattr(stress, "control_sweeps", lambda: (sweep,))
    assert stress_motion(StressArguments(only=["weak"], seeds=2, out=tmp_path)) == 1
    assert "broken bound: weak at 2 kg: 0 of 2 right; went astray" in capsys.readouterr().err


def test_unknown_sweep_is_rejected_with_the_valid_names(tmp_path):
    with pytest.raises(InputError, match=r"'nope'.*out-of-reach.*gain"):
        stress_motion(StressArguments(only=["nope"], out=tmp_path))
    with pytest.raises(InputError, match="--seeds"):
        stress_motion(StressArguments(seeds=0, out=tmp_path))

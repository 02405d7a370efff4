"""The control's stress command: what it judges unclean, refuses, writes and prints."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.bench import StressArguments, Sweep, Trial
from eyehand.apps.motion import stress
from eyehand.apps.motion.invalid_inputs import WrongInput, refused, wrong_inputs
from eyehand.apps.motion.stress import control_sweeps, stress_motion
from eyehand.apps.motion.stress_trial import Motion, fault_of, judged, lbr_world, simulate
from eyehand.control import ControlOptions
from eyehand.control.tasks import Position
from eyehand.errors import InputError


@pytest.fixture(scope="module")
def motion() -> Motion:
    world = lbr_world()
    goal = world.robot.at(world.robot.home).position + np.array([0.0, 0.02, 0.0])
    return simulate(world, [Position(goal)], ControlOptions(), 5.0)


def test_motion_is_recorded_whole(motion):
    assert motion.last.status == "reached"
    assert len(motion.postures) == len(motion.cycles) + 1
    steps = np.diff(motion.postures, axis=0)
    assert steps == pytest.approx(motion.dt * motion.velocities, abs=1e-12)
    assert fault_of(motion, ControlOptions()) == ""
    assert judged(motion, ControlOptions(), passed=True).passed


def test_motion_ends_when_it_has_been_stuck_for_a_while():
    world = lbr_world()
    options = ControlOptions(retreats=0)
    goal = Position(np.array([3.0, 0.0, 0.5]))
    stuck = simulate(world, [goal], options, 60.0, stop_when_stuck=True)
    assert stuck.last.status == "stuck"
    assert len(stuck.cycles) * options.dt < 20.0


def test_faults_are_seen(motion):
    options = ControlOptions()
    nan = replace(motion, postures=np.full_like(motion.postures, np.nan))
    assert "finite" in fault_of(nan, options)
    fast = replace(motion, velocities=3.0 * motion.limits * np.ones_like(motion.velocities))
    assert "300" in fault_of(fast, options)
    near = replace(motion, clearance=np.full_like(motion.clearance, options.margin - 1e-3))
    assert "9.00 mm" in fault_of(near, options)
    assert fault_of(near, options, margin=False) == ""
    assert fault_of(near, replace(options, safety=False)) == ""
    mute = replace(motion.last, status="stuck", reason="")
    assert "without a reason" in fault_of(replace(motion, cycles=(mute,)), options)
    assert not judged(near, options, passed=True).clean


@pytest.mark.parametrize("wrong", wrong_inputs(), ids=lambda wrong: wrong.name)
def test_wrong_input_is_refused_in_words(wrong):
    outcome = refused(wrong)
    assert outcome.kept, outcome.happened
    assert "\n" not in outcome.happened


def test_other_than_a_refusal_is_told():
    assert refused(WrongInput("fine", (), dict)).happened == "accepted"
    assert "ValueError" in refused(WrongInput("crash", (), lambda: int("x"))).happened

    def vague() -> None:
        raise InputError("no")

    assert not refused(WrongInput("vague", ("goal",), vague)).kept


def test_sweeps_have_names_and_bounds_of_their_own():
    sweeps = control_sweeps()
    assert len({sweep.name for sweep in sweeps}) == len(sweeps)
    assert sum(sweep.holds_to is not None for sweep in sweeps) >= 10


def test_command_writes_chart_and_one_json_object(tmp_path, capsys):
    code = stress_motion(
        StressArguments(
            only=["gain", "parallel-cover"], seed=3, quick=True, out=tmp_path, json=True
        )
    )
    assert code == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "eyehand.stress_motion/1"
    assert report["seed"] == 3
    assert [row["name"] for row in report["rows"]] == ["gain", "parallel-cover"]
    assert report["rows"][1]["breaks_at"] == 1.0
    assert report["broken_bounds"] == []
    assert (tmp_path / "stress.png").read_bytes()[:4] == b"\x89PNG"
    with (tmp_path / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["refused_pct"] for row in rows if row["name"] == "gain"] == ["0.0", "100.0"]
    assert all(float(row["gradient_jump_pct"]) > 0 for row in rows if "cover" in row["name"])


def test_inputs_alone_write_no_chart(tmp_path, capsys):
    assert stress_motion(StressArguments(only=["inputs"], out=tmp_path, json=True)) == 0
    report = json.loads(capsys.readouterr().out)
    assert len(report["inputs"]) == len(wrong_inputs())
    assert all(row["kept"] for row in report["inputs"])
    assert list(tmp_path.iterdir()) == []


def test_broken_bound_ends_with_code_1_and_is_named(tmp_path, capsys, monkeypatch):
    def attempt(value: float, seed: int, options: ControlOptions) -> Trial:
        return Trial(value < 2, "went astray")

    sweep = Sweep("weak", "load", "kg", (1.0, 2.0), 2.0, attempt, "stays")
    monkeypatch.setattr(stress, "control_sweeps", lambda: (sweep,))
    assert stress_motion(StressArguments(only=["weak"], seeds=2, out=tmp_path)) == 1
    assert "broken bound: weak at 2 kg: 0 of 2 right; went astray" in capsys.readouterr().err


def test_unknown_sweep_is_refused_with_the_choices(tmp_path):
    with pytest.raises(InputError, match=r"'nope'.*out-of-reach.*inputs"):
        stress_motion(StressArguments(only=["nope"], out=tmp_path))
    with pytest.raises(InputError, match="--seeds"):
        stress_motion(StressArguments(seeds=0, out=tmp_path))

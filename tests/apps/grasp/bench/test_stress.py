"""The stress command of picking: rules, disturbances, sweeps and output."""

import csv
import json

import numpy as np
import pytest

from eyehand.apps.bench.stress import StressArguments
from eyehand.apps.grasp.bench import stress as command
from eyehand.apps.grasp.bench.event_sweeps import PHASES, displaced_scene
from eyehand.apps.grasp.bench.pick_row import PickRow
from eyehand.apps.grasp.bench.stress import grasp_stage, grasp_sweeps, stress_grasp
from eyehand.apps.grasp.bench.stress_objects import can_on_table, object_on_table
from eyehand.apps.grasp.bench.stress_trial import (
    MAX_OBJECT_SPEED,
    StressCell,
    StressOutcome,
    stress_cell,
)
from eyehand.errors import InputError
from eyehand.grasping.observation import observe
from eyehand.grasping.pick_options import PickOptions
from eyehand.grasping.report import ClearReport


@pytest.fixture(scope="module")
def bench() -> StressCell:
    return stress_cell([can_on_table(0)], 0, PickOptions())


def row(outcome="slipped", reason="the object left the hand", touched=0, success=False) -> PickRow:
    return PickRow(
        pick=0, object="can", kind="cylinder", prototype="power", approach="side", rows=5,
        outcome=outcome, reason=reason, success=success, perceive_ms=1.0, plan_ms=1.0, seconds=5.0,
        wall_seconds=1.0, touched_before=touched, pads=4, curl=1.0,
    )  # fmt: skip


def outcome(bench: StressCell, *rows: PickRow, stopped="2 picks failed in a row") -> StressOutcome:
    return StressOutcome(bench, ClearReport((), 1, (), stopped), rows, 1.0)


@pytest.mark.parametrize(
    ("rows", "stopped", "message"),
    [
        ([row()], "2 picks failed in a row", ""),
        ([], "no remaining object can be grasped", ""),
        ([row(touched=2)], "2 picks failed in a row", "2 other bodies touched"),
        ([row(reason="")], "2 picks failed in a row", ""),
        ([row(outcome="", reason="")], "2 picks failed in a row", "without a named outcome"),
        ([row(outcome="unknown")], "2 picks failed in a row", "without a named outcome"),
        ([row(outcome="placed", reason="")], "40 picks made", "reported placed"),
        ([], "clear", "reported clear with 1 on the table"),
    ],
)
def test_violation_compares_report_with_truth(bench, rows, stopped, message):
    violation = outcome(bench, *rows, stopped=stopped).violation
    assert message in violation
    assert bool(violation) == bool(message)
    trial = outcome(bench, *rows, stopped=stopped).trial()
    assert (trial.clean, trial.passed, trial.score) == (not message, False, 0.0)


def test_stop_without_pick_is_refusal_unless_clear(bench):
    assert outcome(bench, stopped="cannot see a table").refused
    assert not outcome(bench, stopped="clear").refused
    assert not outcome(bench, row()).refused


def test_thrown_or_fallen_object_is_violation():
    box = object_on_table("box", (0.04, 0.04, 0.06), 0, offset=(0.1, 0.0))
    bench = stress_cell([can_on_table(0), box], 0, PickOptions())
    assert outcome(bench, row()).violation == ""
    bench.move_object("can", np.array([0.0, 0.9, 0.055]))
    assert "can left the table" in outcome(bench, row()).violation
    bench.remove_object("can")
    assert outcome(bench, row()).violation == ""
    assert outcome(bench, row()).remaining == ("box",)
    bench.peak_speed = MAX_OBJECT_SPEED + 1
    assert "thrown at 4.0 m/s" in outcome(bench, row()).violation


def test_displaced_scene_moves_points_and_solids(bench):
    scene, _, reason = observe(bench.cell)
    assert reason == ""
    assert scene is not None
    offset = np.array([0.01, -0.02, 0.0])
    (before,), (after,) = scene.objects, displaced_scene(scene, offset).objects
    np.testing.assert_allclose(after.points, before.points + offset)
    assert before.fit.superquadric is not None
    assert after.fit.superquadric is not None
    moved = after.fit.superquadric.centre - before.fit.superquadric.centre
    np.testing.assert_allclose(moved, offset, atol=1e-12)


def test_disturbance_happens_once_in_its_phase():
    bench = stress_cell([can_on_table(1)], 1, PickOptions())
    events: list[str] = []
    bench.disturbed_phase, bench.disturb = "approach", lambda: events.append(bench.cell.phase)
    bench.after_selection = lambda: events.append("after the selection")
    result = bench.clear()
    assert events == ["after the selection", "approach"]
    assert result.left == ()
    assert result.violation == ""
    assert bench.creep is not None
    assert bench.creep < 1e-3


def test_sweeps_have_unique_names_and_bounds():
    sweeps = grasp_sweeps()
    assert len({sweep.name for sweep in sweeps}) == len(sweeps) > 20
    assert all(sweep.holds_to is not None for sweep in sweeps)
    assert {len(sweep.values) for sweep in sweeps if "nan" in sweep.name} == {len(PHASES)}
    assert set(command.QUICK) <= {sweep.name for sweep in sweeps}


def test_command_writes_chart_and_prints_one_json_object(tmp_path, capsys):
    names = ["width", "nan-arm"]
    code = stress_grasp(StressArguments(only=names, quick=True, out=tmp_path, json=True))
    report = json.loads(capsys.readouterr().out)
    assert code == 0, report["broken_bounds"]
    assert report["schema"] == "eyehand.stress_grasp/1"
    assert [line["name"] for line in report["rows"]] == names
    assert (tmp_path / "stress.png").read_bytes()[:4] == b"\x89PNG"
    with (tmp_path / "stress.csv").open() as file:
        points = list(csv.DictReader(file))
    assert len(points) == len(report["points"]) == 4
    hardest = {point["name"]: point for point in points}
    assert (hardest["width"]["refused_pct"], hardest["nan-arm"]["refused_pct"]) == ("100.0", "0.0")
    assert {point["unclean"] for point in points} == {"0"}


def test_footer_describes_only_run_sweeps():
    assert grasp_stage(["width"]).report.data == "simulated cell, true poses"
    assert grasp_stage(["camera-roll"]).report.data == "simulated cell, one noisy depth view"
    both = grasp_stage(["width", "camera-roll"])
    assert both.report.data == "simulated cell, true poses, but one noisy depth view in camera-roll"
    every = grasp_stage([sweep.name for sweep in grasp_sweeps()])
    assert "from camera-roll to only-table" in every.report.data


def test_unknown_sweep_is_refused_with_choices(tmp_path):
    with pytest.raises(InputError, match=r"'nope'.*width.*bad-physics"):
        stress_grasp(StressArguments(only=["nope"], out=tmp_path / "none"))
    assert not (tmp_path / "none").exists()

"""`eyehand evaluate motion`: files, rows and messages, and how results are summarised."""

import csv
import json
from functools import partial

import numpy as np
import pytest

from eyehand.apps.motion import evaluate
from eyehand.apps.motion.cycle_comparison import cycle_rows
from eyehand.apps.motion.loop_times import loop_row
from eyehand.apps.motion.reach_methods import (
    BASELINES,
    controller_method,
    reaching_tasks,
    reaching_world,
)
from eyehand.apps.motion.reach_outcome import ReachOptions, ReachOutcome
from eyehand.apps.motion.reach_run import ReachRecord, run_scene, summary_row, wilson_interval
from eyehand.control import JointPath
from eyehand.data_synth.scenes import make_reaching_scene
from eyehand.errors import InputError

from ..command_line import run_command

run = partial(run_command, "evaluate", "motion")


def outcome(**changed) -> ReachOutcome:
    """Return a successful reach, with some values changed."""
    plain = {
        "success": True,
        "contacts": 0,
        "min_clearance": 0.02,
        "seconds": 4.0,
        "final_error": 9e-4,
        "cycle_times_us": np.full(800, 100.0),
        "peak_acceleration": 0.5,
        "peak_jerk": 0.25,
        "status": "reached",
    }
    return ReachOutcome(**{**plain, **changed})


def test_quick_run_prints_a_row_per_method_and_writes_its_files(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(evaluate, "QUICK_MOVING", 1)
    code, out, err = run(
        *("--quick", "--scenes", 2, "--seed", 3, "--boxes", 2, "--out", tmp_path, "--json"),
        *("--only", "null space only", "--only", "default", "--only", "mink"),
        capsys=capsys,
    )
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.evaluate_motion/1"
    assert (report["seed"], report["scenes"], report["boxes"]) == (3, 2, 2)
    rows = {row["name"]: row for row in report["rows"]}
    assert list(rows) == [
        *("null space only", "default", "mink"),
        *("cycle compiled", "cycle mink"),
        *("any side 0.25 m/s", "any side 0.5 m/s", "conveyor 0.25 m/s", "conveyor 0.5 m/s"),
    ]
    for name in ("null space only", "default", "mink"):
        row = rows[name]
        assert 0 <= row["success_low_pct"] <= row["success_pct"] <= row["success_high_pct"] <= 100
        assert 0 < row["cycle_p50_us"] <= row["cycle_p99_us"]
    assert rows["default"]["contacts"] == 0
    assert rows["default"]["min_clearance_mm"] > 9.5
    assert rows["cycle compiled"]["cycle_p50_us"] < rows["cycle mink"]["cycle_p50_us"]
    assert "one cycle with 30 distance pairs" in err
    assert (tmp_path / "bench.png").stat().st_size > 10_000
    with (tmp_path / "scenes.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 6


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--scenes", 0), "--scenes must be >= 1, got 0"),
        (("--seed", -1), "--seed must be >= 0, got -1"),
        (
            ("--time-limit", 0),
            "dt must be > 0 s and at most the time limit, got dt 0.005, time limit 0",
        ),
        (("--boxes", 13), "--boxes must be from 0 to 12, got 13"),
        (("--loop", -1), "--loop must be a finite time >= 0 s, got -1"),
        (("--only", "magic"), "unknown method 'magic'; choose from: null space only,"),
        (
            ("--only", "mink", "--no-baseline"),
            "--no-baseline excludes mink, the only",
        ),
    ],
)
def test_invalid_arguments_are_rejected_in_one_line(arguments, message, tmp_path, capsys):
    code, out, err = run(*arguments, "--out", tmp_path / "none", capsys=capsys)
    assert code == 2
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "none").exists()


def test_same_seed_gives_same_motion():
    first, second = (run_scene("dynamic beta", 4, 3).row() for _ in range(2))
    assert first == second


def test_unknown_controller_is_rejected_with_the_valid_names():
    with pytest.raises(InputError, match="choose from: null space only"):
        controller_method("mink", make_reaching_scene(0, boxes=0))


def test_searches_are_not_counted_as_cycles():
    path = JointPath(True, np.zeros((1, 7)), 0.02, "", 3, 2, 0.4)
    times = np.full(100, 150.0)
    times[40] = 4e5
    record = ReachRecord("default + planner", 1, True, outcome(cycle_times_us=times), "", (path,))
    assert len(record.cycle_times_us) == 99
    assert record.cycle_times_us.max() == 150.0
    assert record.row()["plan_ms"] == "400.0"


def test_summary_counts_scenes():
    outcomes = [
        outcome(),
        outcome(success=False, contacts=40, min_clearance=-0.003),
        outcome(success=False, status="stuck", final_error=0.2),
        outcome(success=False, status="late", final_error=0.1),
    ]
    records = [ReachRecord("default", k, False, one, "") for k, one in enumerate(outcomes)]
    row = summary_row("default", records, np.arange(101.0), 60.0)
    assert (row["success_pct"], row["contacts"]) == (25.0, 1)
    assert (row["stuck_pct"], row["late_pct"]) == (25.0, 25.0)
    assert row["min_clearance_mm"] == -3.0
    assert (row["time_p50_s"], row["time_p90_s"]) == (60.0, 60.0)
    assert (row["peak_acceleration_pct"], row["peak_jerk_pct"]) == (50.0, 25.0)
    assert (row["cycle_p50_us"], row["cycle_p99_us"]) == (50.0, 99.0)
    assert "plan_p50_ms" not in row


@pytest.mark.parametrize(
    ("wins", "tries", "low", "high"),
    [(0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (81, 263, 0.2553, 0.3662)],
)
def test_wilson_intervals_match_published_values(wins, tries, low, high):
    assert wilson_interval(wins, tries) == pytest.approx((low, high), abs=1e-4)


def test_cycle_comparison_uses_the_same_pairs_for_all_methods():
    rows = cycle_rows(0, baseline=True, rounds=1, postures=1)
    assert [row["name"] for row in rows] == ["cycle compiled", "cycle mink"]
    assert {row["pairs"] for row in rows} == {30}
    assert all(0 < row["cycle_p50_us"] <= row["cycle_p99_us"] for row in rows)


def test_missing_packages_are_left_out_with_a_note(monkeypatch, capsys):
    monkeypatch.setattr(evaluate, "find_spec", lambda _name: None)
    left = evaluate._selected_methods(None, baseline=True)
    assert not set(left) & set(BASELINES)
    notes = capsys.readouterr().err.splitlines()
    assert len(notes) == 2
    assert "without the rows mink, mink tuned: mink is not installed" in notes[0]
    assert "without the rows OMPL + IK: ompl is not installed" in notes[1]
    for name in BASELINES:
        with pytest.raises(InputError, match=r"pip install 'eyehand\[baselines\]'"):
            evaluate._selected_methods([name], baseline=True)


def test_loop_at_1_khz_counts_calls_and_searches():
    row = loop_row(2, 0.4)
    assert row["calls"] == 400
    assert 0 < row["step_p50_us"] <= row["step_p999_us"] <= row["step_max_us"]
    assert row["processor_p999_us"] <= row["processor_max_us"] <= row["step_max_us"] + 50


@pytest.mark.parametrize(
    ("place", "goal"), [("shelf", "pose"), ("bin", "axis"), ("neighbours", "position")]
)
def test_goal_in_a_tight_place_is_reached_as_asked(place, goal):
    reach = ReachOptions(place=place, goal=goal)
    record = run_scene("default + planner", 1, 0, reach)
    assert record.outcome.success
    assert record.outcome.min_clearance > 0.0095
    assert record.outcome.peak_acceleration < 1.0 + 1e-6
    scene = make_reaching_scene(1, place=place)
    tasks = reaching_tasks(scene, goal)
    state = reaching_world(()).robot.at(scene.witness)
    assert max(task.at(state).unmet for task in tasks) < 1e-6


def test_unknown_place_or_goal_is_refused():
    with pytest.raises(InputError, match="goal must be one of position, axis, pose, got 'spot'"):
        ReachOptions(goal="spot")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="place must be one of boxes, shelf, bin, neighbours"):
        ReachOptions(place="attic")  # pyright: ignore[reportArgumentType]

"""`eyehand evaluate grasp --protocol clutter-removal`."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from eyehand.apps.grasp import clutter_round
from eyehand.apps.grasp.bench.chart import chart_grasp
from eyehand.apps.grasp.bench.evaluate import evaluate_grasp
from eyehand.apps.grasp.bench.protocol import protocol_jobs
from eyehand.apps.grasp.bench.protocol_settings import ProtocolChoice, ProtocolSettings
from eyehand.apps.grasp.clutter_round import run_clutter_round
from eyehand.apps.grasp.robot_choice import RobotChoice
from eyehand.errors import InputError
from eyehand.grasping import plan_grasps

SHARED = Path(__file__).resolve().parents[5] / "shared" / "data" / "objects"


def test_folder_is_required():
    with pytest.raises(InputError, match="--objects"):
        evaluate_grasp(protocol="clutter-removal")


def test_family_is_checked():
    with pytest.raises(InputError, match="packed or pile, got 'single'"):
        evaluate_grasp(protocol="clutter-removal", family=["single"], objects=SHARED)


def test_hand_is_checked():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    robot = RobotChoice(hand="pandda")
    with pytest.raises(InputError, match="there is no hand 'pandda'"):
        evaluate_grasp(protocol="clutter-removal", robot=robot, objects=SHARED, rounds=1)


def test_table_is_either_known_or_learned():
    with pytest.raises(InputError, match="exclude each other"):
        evaluate_grasp(
            protocol="clutter-removal", objects=SHARED, known_table=True, learned_table=True
        )


def test_misplaced_hand_is_a_setting_of_each_round():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    settings = ProtocolSettings(("pile",), ("dex",), 2, 7, SHARED, misplaced=(5.0, 2.0))
    jobs = protocol_jobs(settings)
    assert {job.row for job in jobs} == {"pile, dex noise, misplaced by 5 mm and 2°"}
    changes = jobs[0].trial["changes"]
    assert changes["calibration_error"] == pytest.approx(0.005)
    assert changes["calibration_angle"] == pytest.approx(math.radians(2.0))
    with pytest.raises(InputError, match="--misplaced must be finite"):
        protocol_jobs(replace(settings, misplaced=(-5.0, 0.0)))


def test_number_and_density_of_objects_are_settings_of_each_round():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    settings = ProtocolSettings(("pile",), ("none",), 1, 7, SHARED, count=2, density=500.0)
    (job,) = protocol_jobs(settings)
    assert job.row == "pile, no noise, 2 objects, 500 kg/m³"
    round_ = run_clutter_round({**job.trial, "max_attempts": 1})
    assert round_["placed"] == 2
    lighter = run_clutter_round({**job.trial, "max_attempts": 1, "density": 50.0})
    first, second = round_["attempts"][0], lighter["attempts"][0]
    assert first["object"] == second["object"]
    assert first["mass"] == pytest.approx(10.0 * second["mass"])
    with pytest.raises(InputError, match="--count must be from 1 to 15, got 16"):
        protocol_jobs(replace(settings, count=16))
    with pytest.raises(InputError, match="density must be > 0"):
        protocol_jobs(replace(settings, density=-1.0))


def test_only_safe_grasps_are_executed(monkeypatch):
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    settings = ProtocolSettings(("packed",), ("dex",), 1, 7, SHARED, safe_only=True)
    (job,) = protocol_jobs(settings)
    assert job.row == "packed, dex noise, only safe grasps"
    round_ = run_clutter_round({**job.trial, "max_attempts": 2})
    assert round_["attempts"]
    assert all(attempt["safe"] for attempt in round_["attempts"])

    def unsafe(*arguments):
        found = plan_grasps(*arguments)
        grasps = [replace(grasp, safe=False, forbidden_by=("a test",)) for grasp in found]
        return replace(found, grasps=tuple(grasps), reason="no grasp is safe: a test")

    monkeypatch.setattr(clutter_round, "plan_grasps", unsafe)
    round_ = run_clutter_round(dict(job.trial))
    assert round_["attempts"] == []
    assert round_["ended"] == "no grasp: no grasp is safe: a test"


def test_quick_run_prints_rows_beside_those_of_others(capsys):
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    code = evaluate_grasp(
        protocol="clutter-removal",
        objects=SHARED,
        family=["packed"],
        noise=["none"],
        quick=True,
        jobs=1,
        json=True,
    )
    assert code == 0
    report = json.loads(capsys.readouterr().out)
    own, *others = report["rows"]
    assert own["attempts"] >= 1
    assert own["first_plan_ms"] > 0
    assert (own["count"], own["density"]) == (5, None)
    assert own["causes_text"]
    assert 0 <= own["success_ci_low_pct"] <= own["success_pct"] <= own["success_ci_high_pct"] <= 100
    assert all("outside" in row["measured_by"] for row in others)
    assert report["rounds"][0]["attempts"][0]["object"]


def test_quick_chart_shows_planning_time_against_success(tmp_path, capsys):
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    choice = ProtocolChoice("clutter-removal", known_table=True, objects=SHARED)
    code = chart_grasp(public=choice, seed=3, quick=True, jobs=1, out=tmp_path, json=True)
    assert code == 0
    report = json.loads(capsys.readouterr().out)
    default, fewer = report["rows"]
    assert default["name"] == "packed, dex noise, table known, default"
    assert fewer["name"].endswith("approaches 8")
    assert default["plan_ms"] > 0 < fewer["plan_ms"]
    assert default["attempts"] >= 1
    assert default["on_front"] or fewer["on_front"]
    assert (tmp_path / "grasp.png").stat().st_size > 10_000
    lines = (tmp_path / "grasp.csv").read_text().splitlines()
    assert len(lines) == 3
    assert "plan_ms" in lines[0]


def test_chart_of_the_protocol_needs_objects_and_a_family_of_it(tmp_path):
    with pytest.raises(InputError, match="--objects"):
        chart_grasp(public=ProtocolChoice("clutter-removal"), out=tmp_path)
    choice = ProtocolChoice("clutter-removal", objects=SHARED)
    with pytest.raises(InputError, match="packed or pile, got 'single'"):
        chart_grasp(public=choice, family="single", out=tmp_path)
    assert not list(tmp_path.iterdir())


def test_round_is_reproducible():
    if not SHARED.is_dir():
        pytest.skip(f"no {SHARED}")
    trial = {"family": "packed", "seed": 11, "objects": str(SHARED / "packed"), "noise": "dex"}
    first, second = run_clutter_round(dict(trial)), run_clutter_round(dict(trial))
    assert first["ended"] == second["ended"]
    assert [a["predicted"] for a in first["attempts"]] == [
        a["predicted"] for a in second["attempts"]
    ]
    assert first["placed"] >= first["removed"] + 0

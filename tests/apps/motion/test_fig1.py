"""Fig. 1 agrees with the chapter, and the command writes its files."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.motion.fig1 import experiment_fig1
from eyehand.apps.motion.fig1_run import (
    BETAS,
    fig1_faults,
    fig1_options,
    fig1_rows,
    fig1_scene,
    run_fig1,
)

NAMES = ["beta 0", "beta 0.5", "beta 1", "beta 2", "beta 5", "dynamic", "default"]


@pytest.fixture(scope="module")
def runs():
    return run_fig1()


def test_results_agree_with_the_chapter(runs):
    by_name = {run.name: run for run in runs}
    assert list(by_name) == NAMES
    assert by_name["beta 0"].error < 1e-4
    assert by_name["dynamic"].error < 1e-4
    assert by_name["default"].error < 1e-4
    assert by_name["dynamic"].midcourse >= 3 * by_name["beta 0"].midcourse
    fixed = [by_name[f"beta {beta}"] for beta in ("0.5", "1", "2", "5")]
    # A larger weight gives more clearance and a larger final error.
    assert np.all(np.diff([run.midcourse for run in fixed]) > 1e-3)
    assert np.all(np.diff([run.error for run in fixed]) > 5e-3)
    assert fixed[0].error > 0.02
    assert fig1_faults(runs) == []


def test_path_without_avoidance_in_task_space_is_straight(runs):
    hand = runs[0].hand
    # Integrating joint velocities over a cycle bends it by a fraction of a millimetre.
    assert np.abs(hand[:, 1] - hand[0, 1]).max() < 5e-4
    assert np.abs(hand[:, 2]).max() < 1e-9


def test_runs_differ_in_the_weight_only():
    plain = {replace(fig1_options(beta), beta=0.0) for beta in BETAS}
    assert len(plain) == 1
    assert replace(fig1_options("dynamic", safety=True), safety=False) == fig1_options("dynamic")


def test_start_is_clear_and_progress_goes_from_0_to_1():
    scene = fig1_scene()
    assert scene.world.proximity(scene.start).distance.min(initial=np.inf) > 0.12
    assert scene.progress(np.stack([scene.hand_start, scene.goal])) == pytest.approx([0.0, 1.0])


def test_broken_statements_are_named(runs):
    by_name = {run.name: run for run in runs}
    swapped = [
        replace(by_name["beta 1"], name="dynamic") if run.name == "dynamic" else run for run in runs
    ]
    assert any("dynamic ends" in fault for fault in fig1_faults(swapped))
    straight = [
        replace(by_name["beta 0"], name="dynamic") if run.name == "dynamic" else run for run in runs
    ]
    assert any("dynamic leaves" in fault for fault in fig1_faults(straight))


def test_command_writes_picture_figures_and_one_json_object(tmp_path, capsys, monkeypatch, runs):
    monkeypatch.setattr("eyehand.apps.motion.fig1.run_fig1", lambda: runs)
    assert experiment_fig1(out=tmp_path / "new", json=True) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["schema"] == "eyehand.experiment_fig1/1"
    assert [row["name"] for row in report["rows"]] == NAMES
    assert report["rows"] == fig1_rows(runs)
    assert {"closest_mm", "midcourse_clearance_mm", "final_error_mm"} <= set(report["rows"][0])
    assert (tmp_path / "new" / "experiment_fig1.png").read_bytes()[:4] == b"\x89PNG"
    with (tmp_path / "new" / "experiment_fig1.csv").open() as file:
        assert [row["name"] for row in csv.DictReader(file)] == NAMES

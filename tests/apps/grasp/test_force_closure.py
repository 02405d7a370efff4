"""The experiment `force-closure`: a grasp beside the centre of mass is improved after contact."""

from __future__ import annotations

import json

import numpy as np
import pytest

from eyehand.apps.grasp.closure_objects import SHAPES
from eyehand.apps.grasp.closure_trial import ClosureTrial, run_closure_trial
from tests.apps.command_line import run_command


@pytest.fixture(scope="module")
def trial() -> ClosureTrial:
    box = next(shape for shape in SHAPES if shape.name == "box")
    return ClosureTrial(box, mass=0.5, offset=0.014, angle=0.15, friction=0.7, seen_error=0.0)


def test_steel_head_moves_the_centre_of_mass_that_a_camera_estimates():
    hammer = next(shape for shape in SHAPES if shape.name == "hammer")
    assert hammer.centre - hammer.seen_centre > 0.015
    item = hammer.world_object(0.4)
    assert np.ptp(item.vertices[:, 0]) == pytest.approx(0.226)


def test_task_moves_the_opposing_axis_to_the_centre_of_mass(trial):
    without = run_closure_trial(trial, "off")
    assert without.offset > 0.012
    for method in ("seen", "felt"):
        found = run_closure_trial(trial, method)
        assert found.lifted, method
        assert found.offset < 0.5 * without.offset, method
        assert found.turn < 0.4 * without.turn, method


def test_command_reports_every_method(tmp_path, capsys):
    code, out, _ = run_command(
        "experiment", "force-closure", "--trials", 1, "--json", "--out", tmp_path, capsys=capsys
    )
    assert code == 0
    rows = json.loads(out)["rows"]
    assert [row["method"] for row in rows] == 2 * ["off", "seen", "felt"]
    assert (tmp_path / "force-closure.png").stat().st_size > 10_000

"""Clouds with known solids, and the figures that fits reach on them."""

import json
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.evaluation.fit_cases import Group, fit_case
from eyehand.apps.evaluation.fit_score import overlap
from eyehand.apps.main import main
from eyehand.perception import Superquadric


def box(x: float, a: float = 0.05) -> Superquadric:
    pose = RigidTransform.from_translation([x, 0.0, 0.0])
    return Superquadric(np.array([a, 0.05, 0.05]), (0.02, 0.02), pose)


@pytest.mark.parametrize(
    ("other", "expected"),
    [(box(0.0), 1.0), (box(0.05), 1 / 3), (box(0.2), 0.0), (box(0.0, 0.025), 0.5)],
)
def test_overlap_of_boxes_is_that_of_their_edges(other, expected):
    assert overlap(box(0.0), other) == pytest.approx(expected, abs=0.015)
    assert overlap(other, box(0.0)) == pytest.approx(expected, abs=0.015)


@pytest.mark.parametrize("group", get_args(Group))
def test_a_cloud_follows_from_its_seed_and_lies_on_its_solid(group):
    case, again = fit_case(group, 3), fit_case(group, 3)
    assert np.array_equal(case.points, again.points)
    assert not np.array_equal(case.points, fit_case(group, 4).points)
    if isinstance(case.truth, Superquadric):
        off = np.abs(case.truth.distance(case.points))
        assert np.median(off) < 0.003
        if "outliers" not in group:
            assert np.quantile(off, 0.9) < 0.01


def test_a_view_shows_the_side_that_faces_it():
    case = fit_case("view-1mm", 5)
    assert case.view_origin is not None
    assert isinstance(case.truth, Superquadric)
    towards = case.view_origin - case.points
    near = np.abs(case.truth.distance(case.points)) < 0.001
    facing = np.einsum("ij,ij->i", case.truth.normals(case.points), towards)
    assert np.mean(facing[near] > 0) > 0.95


def test_the_command_prints_a_row_per_group(tmp_path, capsys):
    with pytest.raises(SystemExit) as leaving:
        main(["evaluate", "fit", "--cases", "2", "--seed", "5", "--out", str(tmp_path), "--json"])
    assert leaving.value.code == 0
    report = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in report["rows"]] == list(get_args(Group))
    assert all(row["iou_median_pct"] > 30 for row in report["rows"])
    assert len((tmp_path / "cases.csv").read_text().splitlines()) == 19

"""`eyehand evaluate fit`: output, files, baselines and rejected input."""

import csv
import json
from functools import partial
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.fitting.bench.clouds import Group
from eyehand.apps.fitting.bench.comparison import summary_rows
from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric

from ...command_line import check_refusal, run_command

HERE = f"{__name__}:"


def ball_of_points(points, view_origin, support_plane):
    """Fit a sphere: a baseline for tests."""
    radius = float(np.linalg.norm(points - points.mean(axis=0), axis=1).mean())
    pose = RigidTransform.from_translation(points.mean(axis=0))
    return Superquadric(np.full(3, radius), (1.0, 1.0), pose)


def ours_again(points, view_origin, support_plane) -> SuperquadricFit:
    """Run our own fit as a baseline."""
    return fit_superquadric(points, view_origin=view_origin, support_plane=support_plane)


def breaks(points, view_origin, support_plane):
    """Raise an exception: a faulty baseline."""
    raise ZeroDivisionError("no points after filtering")


def forgets(points, view_origin, support_plane):
    """Return a value of the wrong type."""
    return points.mean(axis=0)


run = partial(run_command, "evaluate", "fit")


def test_quick_run_prints_a_row_per_group(tmp_path, capsys):
    code, out, _ = run("--quick", "--seed", 5, "--out", tmp_path, "--json", capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.evaluate_fit/1"
    assert (report["seed"], report["cases"]) == (5, 2)
    assert list(dict.fromkeys(row["name"] for row in report["rows"])) == list(get_args(Group))
    for row in report["rows"]:
        assert row["iou_median_pct"] > (30 if row["name"] != "compound" else 0)
        assert row["iou_worst_pct"] <= row["iou_p10_pct"] <= row["iou_median_pct"]
        assert 0 < row["fit_median_ms"] <= row["fit_p90_ms"]
        assert (row["kind_right_pct"] is None) == (row["name"] in ("mismatched", "compound"))
    with (tmp_path / "cases.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 2 * len(report["rows"])
    assert {row["method"] for row in table} == {"eyehand", "eyehand, 1 solid"}
    parts, one = report["rows"][-2:]
    assert one["iou_median_pct"] < parts["iou_median_pct"]


def test_baselines_get_the_same_clouds(tmp_path, capsys):
    baselines = [
        f"--baseline={HERE}{baseline.__name__}" for baseline in (ball_of_points, ours_again, breaks)
    ]
    code, out, err = run(
        "--groups", "view-1mm", "--cases", 3, "--json", "--out", tmp_path, *baselines, capsys=capsys
    )
    assert code == 0
    own, ball, again, broken = json.loads(out)["rows"]
    same = [key for key in own if "_ms" not in key and key != "method"]
    assert [own[key] for key in same] == [again[key] for key in same]
    assert ball["iou_median_pct"] < own["iou_median_pct"]
    assert ball["kind_right_pct"] is None
    assert (broken["iou_median_pct"], broken["failed_pct"]) == (0.0, 100.0)
    assert broken["mean_distance_mm"] is None
    assert "ours_again" in err
    reasons = (tmp_path / "cases.csv").read_text()
    assert "ZeroDivisionError: no points after filtering" in reasons


def test_options_are_passed_to_the_fit(tmp_path, capsys, monkeypatch):
    used = []

    def spy(points, **keywords):
        used.append(keywords["options"])
        return fit_superquadric(points, **keywords)

    monkeypatch.setattr("eyehand.apps.fitting.bench.comparison.fit_superquadric", spy)
    code, _, _ = run(
        "--quick", "--groups", "full", "--optimiser", "lm", "--points", 123, "--out", tmp_path,
        capsys=capsys,
    )  # fmt: skip
    assert code == 0
    assert set(used) == {FitOptions(optimiser="lm", points=123)}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--cases", 0], "--cases must be >= 1"),
        (["--seed", -1], "--seed must be >= 0"),
        (["--baseline", "nobody"], "a baseline must be module:function"),
        (["--baseline", "no_such_module:fit"], "cannot import the baseline 'no_such_module:fit'"),
        (["--baseline", f"{HERE}nothing"], "cannot import the baseline"),
        (["--baseline", f"{HERE}HERE"], "must be callable, got a str"),
        (["--optimiser", "hope"], "optimiser must be one of"),
        (["--budget-ms", "0.0001"], "no fit is as fast as 0.0001 ms"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, tmp_path, capsys):
    check_refusal(run, arguments, message, tmp_path / "out", capsys)


def test_baseline_with_a_wrong_return_type_is_rejected(tmp_path, capsys):
    code, _, err = run(
        "--quick",
        "--groups",
        "full",
        "--baseline",
        f"{HERE}forgets",
        "--out",
        tmp_path,
        capsys=capsys,
    )
    assert code == 2
    assert "must return a Superquadric, a SuperquadricFit or None, got a ndarray" in err


def row(method: str, iou: float, kind: str, true_kind: str, off: float | None) -> dict:
    """Return the row of one cloud."""
    lengths = dict.fromkeys(
        ("mean_distance_mm", "max_distance_mm", "extent_error_mm", "extent_error_pct"), off
    )
    return {
        "group": "full", "method": method, "iou_pct": iou, "kind": kind, "true_kind": true_kind,
        "fit_ms": 2.0, **lengths,
    }  # fmt: skip


def test_summary_of_known_rows():
    rows = [
        row("one", 99.0, "box", "box", 1.0),
        row("two", 80.0, "superquadric", "superquadric", 3.0),
        row("one", 90.0, "ellipsoid", "box", 2.0),
        row("two", 0.0, "", "box", None),
        row("one", 40.0, "superquadric", "", 4.0),
        row("two", 20.0, "superquadric", "", None),
    ]
    one, two = summary_rows(rows)
    assert (one["method"], one["cases"], two["method"]) == ("one", 3, "two")
    assert (one["iou_median_pct"], one["iou_worst_pct"]) == (90.0, 40.0)
    assert one["iou_p10_pct"] == 50.0
    assert one["failed_pct"] == pytest.approx(33.33)
    assert one["kind_right_pct"] == 50.0
    assert one["mean_distance_mm"] == 2.0
    # Most clouds have no solid. A fitter with a single kind has no share of correct kinds.
    assert two["mean_distance_mm"] is None
    assert two["kind_right_pct"] is None

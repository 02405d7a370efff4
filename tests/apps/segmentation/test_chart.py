"""`eyehand chart segmentation`: output, files and rejected arguments."""

import csv
import json
from dataclasses import replace
from functools import partial

import cv2
import numpy as np
import pytest

from eyehand.apps.bench import Measured, Method
from eyehand.apps.bench.dial_chart import DialChart, FrontPlace
from eyehand.apps.segmentation import chart as chart_segmentation
from eyehand.apps.segmentation.baselines import BASELINES
from eyehand.apps.segmentation.chart import BOARD
from eyehand.apps.segmentation.comparison import FIGURES
from eyehand.perception import DepthFrame, SegmentationOptions
from eyehand.perception.segmentation import FRONT_FORMAT

from ..command_line import check_refusal, run_command

run = partial(run_command, "chart", "segmentation")


def test_charts_one_synthetic_frame(tmp_path, capsys, monkeypatch):
    # The other baselines have their own test and take seconds.
    fast = [
        baseline for baseline in BASELINES if baseline.name in ("normal edges", "Open3D DBSCAN")
    ]
    monkeypatch.setattr(chart_segmentation, "BASELINES", fast)
    code, out, err = run(
        "--quick", "--kinds", "separate", "--json", "--out", tmp_path, capsys=capsys
    )
    assert code == 0
    picture = cv2.imread(str(tmp_path / "segmentation.png"))
    assert picture is not None
    assert picture.shape[1] == 1600
    with (tmp_path / "segmentation.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    report = json.loads(out)
    assert report["schema"] == "eyehand.chart_segmentation/1"
    assert (report["seed"], report["frames"]) == (0, 1)
    assert len(report["rows"]) == len(table)
    assert list(table[0]) == [
        "method",
        "name",
        "default",
        "front",
        "median_ms",
        "median_cpu_ms",
        "worst_kinds_pct",
        "all_kinds_pct",
        *BOARD.dials,
    ]
    own = [row for row in report["rows"] if row["method"] == "eyehand"]
    assert [row["name"] for row in own if row["default"]] == ["default"]
    assert any(row["front"] for row in own)
    assert all(row["median_ms"] > 0 for row in report["rows"])
    assert {"eyehand", "normal edges", "Open3D DBSCAN"} == {row["method"] for row in report["rows"]}
    assert "Pareto front" in err


def test_charts_folder_beside_synthetic_kind_without_baselines(tmp_path, capsys):
    scene = tmp_path / "data" / "scene"
    code, _, _ = run_command("synth", "--seed", 3, "--objects", 3, "--out", scene, capsys=capsys)
    assert code == 0
    code, out, _ = run(
        "--dataset", tmp_path / "data", "--kinds", "data", "--kinds", "empty", "--quick",
        "--no-baselines", "--json", "--out", tmp_path, capsys=capsys,
    )  # fmt: skip
    assert code == 0
    report = json.loads(out)
    assert (report["kinds"], report["frames"]) == (["data", "empty"], 2)
    assert {row["method"] for row in report["rows"]} == {"eyehand"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--quick", "--store"], "--store needs all settings"),
        (["--frames", 0], "--frames must be >= 1"),
        (["--dataset", "nowhere"], "no such folder"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, tmp_path, capsys):
    check_refusal(run, arguments, message, tmp_path / "out", capsys)


def find_nothing(frame: DepthFrame) -> np.ndarray:
    """Find no object."""
    return np.zeros(frame.depth.shape, np.int32)


def test_budget_selects_from_stored_front(tmp_path):
    path = tmp_path / "front.json"
    settings = [BOARD.setting(), BOARD.setting({"stride": 2}), BOARD.setting({"stride": 4})]
    figures = [(40.0, 97.0), (12.0, 93.0), (15.0, 80.0)]
    own = [
        Measured(Method("eyehand", setting.name, find_nothing), ms, ms, dict.fromkeys(FIGURES, f))
        for setting, (ms, f) in zip(settings, figures, strict=True)
    ]
    made = chart_segmentation.Provenance("kinds: separate", 5, 2)
    chart = DialChart(chart_segmentation.WORDS, settings, own, [], made)
    place = FrontPlace("segmentation", FRONT_FORMAT, path, "SegmentationOptions")
    assert chart.publish(tmp_path, place, store=False, json=False) is None
    chart.store(place)
    front = FRONT_FORMAT.read(path)
    assert [point.name for point in front.points] == ["stride 2", "default"]
    assert front.default_ms == 40.0
    assert (front.data, front.seed, front.frames) == ("kinds: separate", 5, 2)
    assert replace(SegmentationOptions(), **front.points[0].dials) == settings[1].options
    assert chart.publish(tmp_path, place, store=False, json=False) == 1.0

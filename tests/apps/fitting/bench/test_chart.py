"""`eyehand chart fit`: output, files and rejected input."""

import csv
import json

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.bench import DialChart, FrontPlace, Measured, Method, Provenance
from eyehand.apps.fitting.bench.chart import GROUPS, WORDS
from eyehand.apps.fitting.bench.comparison import OWN
from eyehand.apps.fitting.bench.dials import BOARD, POINTS, SUPERQUADRIC_ONLY
from eyehand.apps.main import main
from eyehand.perception import FitOptions, Superquadric
from eyehand.perception.superquadric import FRONT_FORMAT


def ball(points, view_origin, support_plane):
    """Fit a sphere: a baseline for tests."""
    radius = float(np.linalg.norm(points - points.mean(axis=0), axis=1).mean())
    pose = RigidTransform.from_translation(points.mean(axis=0))
    return Superquadric(np.full(3, radius), (1.0, 1.0), pose)


def run(*arguments, capsys) -> tuple[int, str, str]:
    """Run the command in this process; return exit code, stdout and stderr."""
    with pytest.raises(SystemExit) as exit_info:
        main(["chart", "fit", *(str(argument) for argument in arguments)])
    printed = capsys.readouterr()
    return int(exit_info.value.code or 0), printed.out, printed.err


def test_quick_chart_with_a_baseline(tmp_path, capsys):
    code, out, err = run(
        "--quick", "--cases", 1, "--no-baselines", "--baseline", f"{__name__}:ball", "--json",
        "--out", tmp_path, capsys=capsys,
    )  # fmt: skip
    assert code == 0
    picture = cv2.imread(str(tmp_path / "fit.png"))
    assert picture is not None
    assert picture.shape[1] == 1600
    with (tmp_path / "fit.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    report = json.loads(out)
    assert report["schema"] == "eyehand.chart_fit/1"
    assert (report["seed"], report["cases"], report["groups"]) == (0, 3, list(GROUPS))
    assert len(report["rows"]) == len(table)
    figures = ["iou_p10_pct", "iou_median_pct", "failed_pct"]
    common = ["method", "name", "default", "front", "median_ms", "median_cpu_ms"]
    assert list(table[0]) == [*common, *figures, *BOARD.dials]
    own = [row for row in report["rows"] if row["method"] == "eyehand"]
    assert [row["name"] for row in own if row["default"]] == ["default"]
    assert any(row["front"] for row in own)
    ladderless, baseline = (row for row in report["rows"] if row["method"] != "eyehand")
    assert ladderless["method"] == "ours, superquadric only"
    assert baseline["name"] == "1000 points"
    assert baseline["iou_median_pct"] < own[0]["iou_median_pct"]
    assert "Pareto front" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--quick", "--store"], "--store needs all settings"),
        (["--cases", 0], "--cases must be >= 1"),
        (["--seed", -1], "--seed must be >= 0"),
        (["--baseline", "nobody"], "a baseline must be module:function"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, tmp_path, capsys):
    code, out, err = run(*arguments, "--out", tmp_path / "out", capsys=capsys)
    assert code == 2
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert out == ""
    assert not (tmp_path / "out").exists()


def test_board_varies_every_dial_alone_and_repeats_no_setting():
    settings = BOARD.settings()
    assert settings[0].name == "default"
    assert settings[0].options == FitOptions()
    assert len({setting.name for setting in settings}) == len(settings)
    assert {setting.options for setting in BOARD.settings(quick=True)} <= {
        setting.options for setting in settings
    }
    alone = [setting.dials for setting in settings if len(setting.dials) == 1]
    for key in ("optimiser", "silhouette_rays", "plane_weight", "kinds"):
        assert any(key in dials for dials in alone)
    charted = {setting.options.points for setting in settings}
    assert set(POINTS) <= charted


def test_setting_names_state_the_difference():
    assert (
        BOARD.setting({"points": 100, "kinds": SUPERQUADRIC_ONLY}).name
        == "100 points, superquadric only"
    )
    words = BOARD.setting({"silhouette_rays": 0, "plane_weight": 0.0, "optimiser": "lm"}).name
    assert words == "lm, no rays, no plane"


def test_budget_selects_from_stored_front(tmp_path):
    path = tmp_path / "front.json"
    settings = [
        BOARD.setting(),
        BOARD.setting({"points": 100, "optimiser": "lm", "kinds": SUPERQUADRIC_ONLY}),
        BOARD.setting({"points": 200, "optimiser": "lm"}),
    ]
    own = [
        Measured(
            Method(OWN, setting.name, lambda case: None),
            ms,
            ms,
            {"iou_p10_pct": p10, "iou_median_pct": p10 + 2, "failed_pct": 0.0},
        )
        for setting, (ms, p10) in zip(
            settings, [(20.0, 93.0), (3.0, 85.0), (5.0, 80.0)], strict=True
        )
    ]
    chart = DialChart(WORDS, settings, own, [], Provenance("three clouds", 7, 3, "cloud"))
    chart.store(FrontPlace("fit", FRONT_FORMAT, path, "FitOptions"))
    front = FRONT_FORMAT.read(path)
    assert [point.median_ms for point in front.points] == [3.0, 20.0]
    assert FitOptions(**front.points[0].fields) == settings[1].options
    assert FitOptions.for_budget(4.0, front=front) == settings[1].options
    assert FitOptions.for_budget(20.0, front=front) == FitOptions()

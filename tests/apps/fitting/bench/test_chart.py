"""`eyehand chart fit`: output, files and rejected input."""

import csv
import json
from functools import partial

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.bench import Measured, Method, Provenance
from eyehand.apps.bench.dial_chart import DialChart, FrontPlace
from eyehand.apps.fitting.bench.chart import BOARD, GROUPS, POINTS, SUPERQUADRIC_ONLY, WORDS
from eyehand.apps.fitting.bench.clouds import MESHES
from eyehand.apps.fitting.bench.comparison import OWN
from eyehand.apps.fitting.bench.fit_answer import FitAnswer
from eyehand.apps.fitting.bench.household_meshes import HouseholdMesh
from eyehand.apps.fitting.bench.mesh_cases import MeshTruth, case_iou, mesh_case
from eyehand.apps.fitting.bench.mesh_views import PlacedMesh, mesh_views
from eyehand.apps.fitting.bench.score import overlap
from eyehand.perception import FitOptions, Superquadric
from eyehand.perception.superquadric import FRONT_FORMAT, mesh

from ...command_line import check_refusal, run_command


def ball(points, view_origin, support_plane):
    """Fit a sphere: a baseline for tests."""
    radius = float(np.linalg.norm(points - points.mean(axis=0), axis=1).mean())
    pose = RigidTransform.from_translation(points.mean(axis=0))
    return Superquadric(np.full(3, radius), (1.0, 1.0), pose)


run = partial(run_command, "chart", "fit")


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
    assert (report["seed"], report["cases"], report["groups"]) == (0, 4, list(GROUPS))
    assert len(report["rows"]) == len(table)
    figures = ["iou_mean_pct", "iou_p10_pct", "iou_median_pct", "failed_pct"]
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
        (["--store"], "--store needs real objects"),
        (["--meshes", "nowhere", "--quick"], "there is no folder nowhere"),
        (["--baseline", "nobody"], "a baseline must be module:function"),
    ],
)
def test_invalid_arguments_give_one_line_error(arguments, message, tmp_path, capsys):
    check_refusal(run, arguments, message, tmp_path / "out", capsys)


def test_household_meshes_are_a_group_of_the_chart(tmp_path, capsys):
    folder = tmp_path / "meshes"
    folder.mkdir()
    solid = Superquadric(np.array([0.03, 0.04, 0.05]), (0.1, 0.1), RigidTransform.identity())
    vertices, faces = mesh(solid, 32)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    (folder / "brick.obj").write_text("\n".join(lines))
    code, out, _ = run(
        *("--quick", "--cases", 1, "--no-baselines", "--meshes", folder, "--json"),
        *("--out", tmp_path / "out"),
        capsys=capsys,
    )
    assert code == 0
    report = json.loads(out)
    # Two views of the mesh, and a cloud of each other group.
    assert report["groups"] == [*GROUPS, MESHES]
    assert report["cases"] == len(GROUPS) + 2
    own = report["rows"][0]
    assert own["mesh_iou_mean_pct"] > 85
    assert 0 < own["iou_mean_pct"] <= 100


def test_a_mesh_is_a_true_solid(tmp_path):
    half = np.array([0.03, 0.04, 0.05])
    pose = RigidTransform.from_components([0.2, 0.1, 0.3], Rotation.from_rotvec([0.2, 0.4, 1.0]))
    solid = Superquadric(half, (0.1, 0.1), RigidTransform.identity())
    item = HouseholdMesh("brick", "test", "box", "report", *mesh(solid, 64))
    truth = MeshTruth(PlacedMesh(item, pose))
    moved = Superquadric(half, (0.1, 0.1), pose)
    assert overlap(truth, [moved]) > 0.98
    assert truth.centre == pytest.approx(moved.centre, abs=1e-3)
    (view,) = mesh_views([item], (40.0,))
    case = mesh_case(view, 0, 500)
    assert case.points.shape == (500, 3)
    answer = FitAnswer((Superquadric(half, (0.1, 0.1), view.placed[0].pose),))
    assert case_iou(case, answer) > 0.98
    assert case_iou(case, FitAnswer((), "refused")) == 0.0


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
            {
                "iou_mean_pct": p10 - 5,
                "iou_p10_pct": p10,
                "iou_median_pct": p10 + 2,
                "failed_pct": 0.0,
            },
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

"""`eyehand evaluate fit --meshes` on folders written by the tests, and on the shared meshes."""

import csv
import json
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.fitting.bench.evaluate_meshes import mesh_summary
from eyehand.apps.fitting.bench.household_meshes import HouseholdMesh, read_household
from eyehand.apps.fitting.bench.mesh_classes import MeshClass
from eyehand.apps.fitting.bench.mesh_scenes import mesh_scenes, place_together
from eyehand.apps.fitting.bench.mesh_score import NOT_FOUND, MeshScore
from eyehand.apps.fitting.bench.mesh_trials import scene_trials, view_trials
from eyehand.apps.fitting.bench.mesh_views import mesh_views
from eyehand.perception import FitOptions, Superquadric
from eyehand.perception.superquadric import mesh

from ...command_line import run_command

SHARED = Path(__file__).parents[4] / ".." / "shared" / "data" / "meshes"
SIZES = {
    "brick": ((0.03, 0.04, 0.05), (0.1, 0.1)),
    "tin": ((0.035, 0.035, 0.05), (0.1, 1.0)),
    "egg": ((0.03, 0.03, 0.04), (1.0, 1.0)),
}


def solids() -> list[HouseholdMesh]:
    """Return a brick, a tin and an egg."""
    found = []
    for name, (half, exponents) in SIZES.items():
        solid = Superquadric(np.array(half), exponents, RigidTransform.identity())
        found.append(HouseholdMesh(name, "test", "other", "report", *mesh(solid, 48)))
    return found


@pytest.fixture
def folder(tmp_path) -> Path:
    """Return a folder with the three solids and their classes."""
    made = tmp_path / "meshes"
    made.mkdir()
    for item in solids():
        lines = [f"v {x} {y} {z}" for x, y, z in item.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in item.faces + 1]
        (made / f"{item.name}.obj").write_text("\n".join(lines))
    (made / "classes.csv").write_text("name,class\nbrick,box\ntin,can\negg,fruit\n")
    return made


run = partial(run_command, "evaluate", "fit")


def ball(points, view_origin, support_plane) -> Superquadric:
    """Return a small ball at the middle of the points: a bad baseline."""
    pose = RigidTransform.from_translation(points.mean(axis=0))
    return Superquadric(np.full(3, 0.01), (1.0, 1.0), pose, "sphere")


def fails(points, view_origin, support_plane):
    """Raise an exception: a faulty baseline."""
    raise ZeroDivisionError("no points")


def test_rows_per_class_and_method(folder, tmp_path, capsys):
    out = tmp_path / "out"
    code, printed, _ = run(
        "--meshes", folder, "--views", 40, "face", "--out", out, "--json", capsys=capsys
    )
    assert code == 0
    report = json.loads(printed)
    assert (report["schema"], report["views"]) == ("eyehand.evaluate_fit/1", 6)
    rows = {(row["name"], row["method"]): row for row in report["rows"]}
    assert {name for name, _ in rows} == {"all", "even", "box", "can", "fruit"}
    own, ems = rows["all", "eyehand, 1 solid"], rows["all", "ems"]
    assert own["fits"] == ems["fits"] == 6
    assert own["iou_median_pct"] > 90
    assert own["usable_pct"] > 60
    with (out / "fits.csv").open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 18
    picture = cv2.imread(str(out / "worst.png"))
    assert picture is not None
    assert picture.shape[1] == 1600


def test_neighbours_are_perceived_without_knowledge(folder, tmp_path, capsys):
    code, printed, _ = run(
        *("--meshes", folder, "--neighbours", "--views", 45, "--max-parts", 1),
        *("--noise", "realistic", "--out", tmp_path / "out", "--json"),
        capsys=capsys,
    )
    assert code == 0
    rows = {(row["name"], row["method"]): row for row in json.loads(printed)["rows"]}
    assert rows["all", "eyehand"]["fits"] > 6
    assert rows["all", "eyehand"]["iou_median_pct"] > 75


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--poses", 0], "--poses must be >= 1"),
        (["--views", "up"], "--views must be elevations"),
        (["--views", 90], "--views must be elevations"),
        (["--views", "nan"], "--views must be elevations"),
        (["--neighbours", "--views", "face"], "--views must be elevations with --neighbours"),
        (["--neighbours", "--hidden", 30], "--hidden needs objects without --neighbours"),
        (["--hidden", 30, 100], "--hidden must be percentages within [0, 95]"),
        (["--hidden", "nan"], "--hidden must be percentages within [0, 95]"),
    ],
)
def test_bad_options_give_one_line(arguments, message, folder, tmp_path, capsys):
    code, out, err = run("--meshes", folder, *arguments, "--out", tmp_path / "out", capsys=capsys)
    assert code == 2
    assert message in err
    assert len(err.strip().splitlines()) == 1
    assert out == ""


def test_an_empty_half_is_refused(folder, tmp_path, capsys):
    (folder / "brick.obj").unlink()
    (folder / "egg.obj").unlink()
    other = {"settings": "report", "report": "settings"}[read_household([folder])[0].half]
    code, _, err = run(
        *("--meshes", folder, "--half", other, "--out", tmp_path / "out"), capsys=capsys
    )
    assert code == 2
    assert f"no mesh of the half {other}" in err


def test_baselines_get_the_points_of_the_fit():
    (view,) = mesh_views(solids()[:1], (45.0,))
    methods = {"own": FitOptions()}
    own, bad, broken = view_trials(view, methods, {"ball": ball, "broken": fails})
    assert own.score.usable
    assert bad.score.iou < 0.1
    assert bad.score.unsaid_iou
    assert broken.score.refused
    assert broken.score.reason == "ZeroDivisionError: no points"


def test_objects_that_are_not_found_count_as_refused(monkeypatch):
    (view,) = mesh_scenes(solids(), (45.0,))[:1]
    flat = view.frame.depth.copy()
    # Without its readings the first object cannot be found.
    flat[view.object_pixels == 1] = 0.0
    object.__setattr__(view.frame, "depth", flat)
    trials = scene_trials(view, {"own": FitOptions()}, {"ball": ball})
    first = [trial for trial in trials if trial.label == 1]
    assert [trial.score.refused for trial in first] == [True, True]
    assert first[0].score.reason == NOT_FOUND
    assert mesh_summary([("box", trial.score) for trial in first], "own")[0]["not_found_pct"] == 100


def test_neighbours_stand_apart_but_close():
    placed = place_together(solids(), np.random.default_rng(3))
    assert len(placed) == 3
    plans = [item.pose.apply(item.mesh.vertices)[:, :2] for item in placed]
    for index, plan in enumerate(plans[1:], start=1):
        gaps = [
            np.linalg.norm(plan[:, None] - other[None], axis=2).min() for other in plans[:index]
        ]
        assert 0.009 < min(gaps) < 0.06


def score(iou: float, error: float, sides=()) -> MeshScore:
    """Return a score with this IoU, width error and errors of sides."""
    return MeshScore(
        *(iou, iou, iou, 0.001, error, 0.05, True, False, False, 1),
        *(np.array(sides), 0.01),
    )


def test_every_class_has_the_same_weight_in_the_even_row():
    fits: list[tuple[MeshClass, MeshScore]] = [("box", score(0.9, 0.001, [0.5, 3.0]))] * 3
    fits.append(("tool", score(0.3, 0.02)))
    every, even, box, tool = mesh_summary(fits, "own")
    assert (every["usable_pct"], even["usable_pct"]) == (75.0, 50.0)
    assert (every["unsaid_iou_pct"], even["unsaid_iou_pct"]) == (25.0, 50.0)
    assert (box["width_error_p90_mm"], tool["width_error_p90_mm"]) == (1.0, 20.0)
    assert box["sides_1_sigma_pct"] == every["sides_1_sigma_pct"] == 50.0
    assert tool["sides_1_sigma_pct"] is None


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared meshes are absent")
def test_shared_meshes_divide_into_two_halves():
    meshes = read_household([SHARED])
    halves = [read_household([SHARED], half) for half in ("settings", "report")]
    assert len(meshes) == len(halves[0]) + len(halves[1])
    by_name = {item.name: item for item in meshes}
    bowl = by_name["024_bowl"]
    assert bowl.kind == "vessel"
    volume = np.count_nonzero(bowl.in_material) * bowl.sample_volume
    hull = np.count_nonzero(bowl.in_hull) * bowl.sample_volume
    assert 0.03 < volume / hull < 0.15

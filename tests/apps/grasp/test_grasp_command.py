"""`eyehand grasp`: output, files and rejected input."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from eyehand.apps.grasp.jaw_table import DOUBTS
from eyehand.apps.grasp.moveit_yaml import _text
from eyehand.apps.perceived_frame import support_line
from eyehand.grasping.hands import built_in_hands, load_hand, write_hand
from eyehand.perception import DepthFrame, perceive, read_frame, write_frame

from ...browser import TWO_LOOKS, check_page
from ..command_line import run_command

NAMES = ", ".join(built_in_hands())
SAMPLE = Path(__file__).resolve().parents[3] / "apps" / "sample" / "depth.png"


run = partial(run_command, "grasp")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with all files of one run."""
    return tmp_path_factory.mktemp("grasps")


@pytest.fixture
def report(written: Path, capsys: pytest.CaptureFixture[str]) -> dict:
    """Return the JSON report of one run on the sample frame, and write its files."""
    file = written / "report.json"
    if not file.exists():
        files = ("--yaml", written / "a.yaml", "--picture", written / "new" / "a.png")
        code, out, _ = run(SAMPLE, "--hand", "panda", *files, "--json", "--top", 20, capsys=capsys)
        assert code == 0
        assert len(out.strip().splitlines()) == 1
        file.write_text(out)
    return json.loads(file.read_text())


def test_report_has_ranked_grasps_with_units(report):
    assert report["schema"] == "eyehand.grasp/1"
    assert report["hand"] == "panda"
    rows = report["rows"]
    assert [row["rank"] for row in rows] == list(range(1, len(rows) + 1))
    chances = [row["success_pct"] for row in rows]
    assert chances == sorted(chances, reverse=True)
    for row in rows:
        assert 0.0 < row["object_width_mm"] < row["opening_mm"] + 1e-6 <= 80.0 + 1e-6
        assert row["safe"] == (not row["forbidden_by"])
        assert row["approach"] in ("from above", "oblique", "from the side")
        turn = Rotation.from_quat(row["tool"]["quat_wxyz"], scalar_first=True).as_matrix()
        np.testing.assert_allclose(turn[:, 2], row["approach_direction"], atol=1e-4)
        np.testing.assert_allclose(turn[:, 0], row["closing_direction"], atol=1e-4)
        shift = np.subtract(row["tool"]["position_m"], row["pre_grasp"]["position_m"])
        np.testing.assert_allclose(shift, 0.05 * turn[:, 2], atol=1e-5)
        assert set(row["terms"]) >= {"clearance", "object"}


def test_every_object_has_a_rank_or_a_reason(report):
    (frame,) = report["frames"]
    assert frame["frame"] == "world"
    for item in frame["objects"]:
        assert (item["best_rank"] is None) == bool(item["reason"])
    assert any(item["best_rank"] == 1 for item in frame["objects"])


def test_small_numbers_are_no_texts_in_yaml():
    yaml = pytest.importorskip("yaml")
    assert yaml.safe_load(_text([-4e-06, 1.5e-05, 3.0, 0.25])) == [-4e-06, 1.5e-05, 3.0, 0.25]


def test_yaml_has_the_layout_of_moveit_grasps(report, written):
    yaml = pytest.importorskip("yaml")
    grasps = yaml.safe_load((written / "a.yaml").read_text())
    safe = [row for row in report["rows"] if row["safe"]]
    assert len(grasps) == len(safe) > 0
    for grasp, row in zip(grasps, safe, strict=True):
        assert list(grasp) == [
            "id",
            "pre_grasp_posture",
            "grasp_posture",
            "grasp_pose",
            "grasp_quality",
            "pre_grasp_approach",
            "post_grasp_retreat",
            "post_place_retreat",
            "max_contact_force",
            "allowed_touch_objects",
        ]
        assert grasp["grasp_pose"]["header"]["frame_id"] == "world"
        pose = grasp["grasp_pose"]["pose"]
        assert list(pose["position"].values()) == row["tool"]["position_m"]
        w, x, y, z = row["tool"]["quat_wxyz"]
        assert pose["orientation"] == {"x": x, "y": y, "z": z, "w": w}
        direction = grasp["pre_grasp_approach"]["direction"]["vector"]
        np.testing.assert_allclose(list(direction.values()), row["approach_direction"], atol=1e-5)
        assert grasp["pre_grasp_approach"]["desired_distance"] == pytest.approx(0.05)
        posture = grasp["pre_grasp_posture"]
        assert posture["joint_names"] == ["finger_joint1", "finger_joint2"]
        assert sum(posture["points"][0]["positions"]) == pytest.approx(
            row["opening_mm"] / 1e3, abs=1e-5
        )
        assert grasp["grasp_posture"]["points"][0]["positions"] == [0.0, 0.0]
        assert grasp["max_contact_force"] == 70.0


def test_joint_prefix_precedes_the_joint_names(tmp_path, capsys):
    yaml = pytest.importorskip("yaml")
    path = tmp_path / "a.yaml"
    hand = "--hand", "panda", "--joint-prefix", "panda_"
    assert run(SAMPLE, *hand, "--yaml", path, capsys=capsys)[0] == 0
    names = yaml.safe_load(path.read_text())[0]["grasp_posture"]["joint_names"]
    assert names == ["panda_finger_joint1", "panda_finger_joint2"]


def test_picture_shows_the_best_grasp_in_its_colour(report, written):
    picture = cv2.imread(str(written / "new" / "a.png"))
    assert picture is not None
    assert picture.shape[0] > 700
    assert (picture[..., ::-1] == (0, 158, 115)).all(axis=2).sum() > 500


@pytest.fixture
def page(written, capsys) -> Path:
    """Return the 3D page of one run on the sample frame."""
    pytest.importorskip("viser")
    file = written / "a.html"
    if not file.exists():
        assert run(SAMPLE, "--stroke", 90, "--page", file, capsys=capsys)[0] == 0
    return file


def test_page_holds_the_list_of_grasps(page):
    text = page.read_text()
    assert text.lstrip().lower().startswith("<!doctype html")
    assert "<title>Grasps of depth.png: generic</title>" in text
    assert "object 3, 66 mm wide, " in text
    assert "the pale box is the palm of grasp 1" in text
    assert "warning: object 1 may be more or less than one object" in text


def test_page_works_in_a_browser(page, browser):
    check_page(browser, page.as_uri(), TWO_LOOKS)
    browser.wait_for("document.querySelector('canvas[data-engine]') !== null")


def test_known_table_corrects_the_depth(capsys):
    code, out, err = run(
        SAMPLE, "--hand", "2f85", "--table-height", 0.0, "--json", "--top", 1, capsys=capsys
    )
    assert code in (0, 1)
    correction = json.loads(out)["frames"][0]["depth_correction"]
    assert correction["scale"] == pytest.approx(1.0, abs=0.02)
    assert "depth scaled by" in err
    assert "the support is at z = 0 mm in the world, tilted by 0.0°" in err
    assert "warning: the scale" not in err


def test_distance_of_the_support_is_printed_without_a_pose():
    frame = read_frame(SAMPLE)
    assert frame.T_world_camera is not None
    line = support_line(perceive(replace(frame, T_world_camera=None)))
    distance = re.fullmatch(r"the camera is (\d+) mm from the plane of the support", line)
    assert distance is not None, line
    assert float(distance[1]) == pytest.approx(1e3 * frame.T_world_camera.translation[2], abs=5)


def test_wrong_height_of_the_table_makes_no_grasp_safe(capsys):
    code, out, err = run(SAMPLE, "--hand", "2f85", "--table-height", 0.05, "--json", capsys=capsys)
    assert code == 1
    report = json.loads(out)
    change = report["frames"][0]["depth_correction"]["scale"] - 1.0
    assert change == pytest.approx(-0.078, abs=0.002)
    assert f"warning: the scale of the depth changed by {change:.1%}".replace("%", " %") in err
    assert all("the scale of the depth" in row["forbidden_by"][-1] for row in report["rows"])


@pytest.mark.parametrize(("option", "named"), [((), True), (("--depth-error", 0.5), False)])
def test_largest_doubt_of_the_best_grasp_is_named(option, named, capsys):
    _, out, err = run(SAMPLE, "--hand", "panda", *option, "--json", capsys=capsys)
    assert ("grasp 1: the scale of the depth is uncertain. --table-height" in err) == named
    terms = json.loads(out)["rows"][0]["terms"]
    assert (terms["depth_error"] > 0.8) != named
    assert set(terms) == set(DOUBTS)


def test_folder_gets_report_yaml_and_picture(tmp_path, capsys):
    assert run(SAMPLE, "--hand", "2f85", "--out", tmp_path / "o", "--top", 3, capsys=capsys)[0] == 0
    names = {path.name for path in (tmp_path / "o").iterdir()}
    assert names == {"grasps.json", "grasps.yaml", "grasps.png"}
    assert len(json.loads((tmp_path / "o" / "grasps.json").read_text())["rows"]) == 3


def test_file_of_a_hand_is_read(tmp_path, capsys):
    write_hand(load_hand("panda"), tmp_path / "mine.json")
    code, out, _ = run(SAMPLE, "--hand", tmp_path / "mine.json", "--json", capsys=capsys)
    assert code == 0
    assert json.loads(out)["rows"]


def test_pose_for_a_hand_with_one_moving_jaw_is_named(tmp_path, capsys):
    file = tmp_path / "mine.json"
    write_hand(replace(load_hand("panda"), name="mine", middle_shift=(0.04, 0.0), tool=None), file)
    code, _, err = run(SAMPLE, "--hand", file, "--top", 1, capsys=capsys)
    assert code == 0
    assert "mine: one jaw moves, so the arm must go to hand.closed_pose of a grasp" in err


def test_small_gripper_gets_no_grasp_and_a_reason(capsys):
    code, out, err = run(SAMPLE, "--stroke", 5, "--json", capsys=capsys)
    assert code == 1
    assert json.loads(out)["rows"] == []
    assert "mm wide where jaws reach, wider than the stroke of 5 mm" in err


def test_empty_table_says_that_there_are_no_objects(tmp_path, capsys):
    frame = read_frame(SAMPLE)
    assert frame.T_world_camera is not None
    rays = frame.T_world_camera.rotation.apply(frame.intrinsics.rays().reshape(-1, 3))
    depth = (-frame.T_world_camera.translation[2] / rays[:, 2]).reshape(frame.depth.shape)
    noise = np.random.default_rng(0).normal(0, 0.001, depth.shape)
    depth = np.where((depth > 0) & (depth < 1.5), depth + noise, 0).astype(np.float32)
    empty = DepthFrame(depth, frame.intrinsics, T_world_camera=frame.T_world_camera)
    write_frame(tmp_path / "depth.png", empty)
    code, out, err = run(tmp_path / "depth.png", "--hand", "panda", capsys=capsys)
    assert code == 1
    assert out == ""
    assert "no grasp is offered: the scene has no objects" in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((SAMPLE,), f"give the gripper: --hand NAME ({NAMES})"),
        ((SAMPLE, "--hand", "pandda"), f"no hand 'pandda'; valid names are {NAMES}"),
        ((SAMPLE, "--hand", "gone.json"), "gone.json: cannot read a hand"),
        ((SAMPLE, "--hand", "panda", "--stroke", 80), "give either --hand panda or --stroke"),
        ((SAMPLE, "--stroke", -5), "--stroke must be above 0 and below 1000 mm, got -5"),
        ((SAMPLE, "--stroke", "nan"), "--stroke must be above 0"),
        ((SAMPLE, "--stroke", 0.085), "got 0.085 mm. Is this in metres? Then write 85"),
        (
            (SAMPLE, "--hand", "panda", "--depth-error", 30),
            "--depth-error must be 0, or 0.05 to 20 %",
        ),
        ((SAMPLE, "--hand", "panda", "--depth-error", 0.005), "0.05 to 20 %, got 0.005"),
        ((SAMPLE, "--hand", "generic", "--finger-depth", 0), "--finger-depth must be above 0"),
        ((SAMPLE, "--hand", "panda", "--calibration-error", 99), "--calibration-error must be"),
        ((SAMPLE, "--hand", "panda", "--friction", -1), "friction must be from 0 to 3"),
        ((SAMPLE, "--hand", "panda", "--top", 0), "--top must be >= 1"),
        ((SAMPLE, "--hand", "panda", "--picture", "a.jpg"), "--picture must name a .png file"),
        ((SAMPLE, "--hand", "panda", "--table-height", 0.2), "--table-height 0.2 does not fit"),
        (("gone.png", "--hand", "panda"), "gone.png"),
        (("a.mcap", "--hand", "panda", "--yaml", "a.yaml"), "--yaml needs one frame"),
        (("--hand", "panda"), "give either a frame file or --oak"),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, message, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(*arguments, capsys=capsys)
    assert code == 2
    assert out == ""
    # The first run of a new installation says before that it compiles its kernels.
    (line,) = [one for one in err.splitlines() if not one.startswith("first run: ")]
    assert line.startswith("eyehand: ")
    assert message in line


def test_picture_without_grasps_shows_the_objects(tmp_path, capsys):
    picture = tmp_path / "none.png"
    code, _, _ = run(SAMPLE, "--stroke", 5, "--picture", picture, capsys=capsys)
    assert code == 1
    assert cv2.imread(str(picture)) is not None

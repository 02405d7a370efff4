"""Commands: output, files and rejected input."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from eyehand.apps.command_table import COMMANDS
from eyehand.perception import CameraIntrinsics, DepthFrame, read_frame, write_cloud, write_frame
from eyehand.perception.cameras import write_ros_frames

from .command_line import run_command as run

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"


def picture(path: Path) -> np.ndarray:
    """Read a PNG with its full bit depth."""
    read = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert read is not None
    return read


def cloud_file(path: Path) -> Path:
    """Write the cloud of a noisy ball of 40 mm radius at (0.1, 0.2, 0.3)."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(800, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    write_cloud(path, [0.1, 0.2, 0.3] + 0.04 * directions + rng.normal(size=(800, 3)) * 0.0005)
    return path


@pytest.fixture
def flat(monkeypatch) -> None:
    """Disable OpenGL, which takes seconds to start."""
    monkeypatch.setenv("MUJOCO_GL", "disable")


def test_perceive_writes_its_files_and_one_json_object(tmp_path, capsys):
    code, out, err = run("perceive", SAMPLE, "--out", tmp_path, "--json", capsys=capsys)
    assert code == 0
    report = json.loads(out)
    assert report["schema"] == "eyehand.perceive/1"
    assert report["rows"][0]["name"] == "frame"
    assert report["rows"][0]["perceive_ms"] > 0
    assert "objects" in err
    scene = json.loads((tmp_path / "scene.json").read_text())
    assert scene["schema"] == "eyehand.scene/1"
    assert scene["units"]["quaternion"] == "wxyz"
    assert scene["frame"] == "world"
    assert len(scene["objects"]) == report["rows"][0]["objects"] > 0
    for item in scene["objects"]:
        assert len(item["fit"]["solid"]["quat_wxyz"]) == 4
        assert np.linalg.norm(item["fit"]["solid"]["quat_wxyz"]) == pytest.approx(1.0, abs=1e-4)
    labels = picture(tmp_path / "labels.png")
    assert labels.dtype == np.uint16
    assert labels.max() == len(scene["objects"])
    overlay = picture(tmp_path / "overlay.png")
    assert overlay.shape[1] >= 1280
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "labels.png",
        "overlay.png",
        "scene.json",
    ]


def test_perceive_accepts_a_camera_file_and_a_frame_without_pose(tmp_path, capsys):
    frame = read_frame(SAMPLE)
    write_frame(tmp_path / "bare.npz", DepthFrame(frame.depth, frame.intrinsics))
    code, out, _ = run(
        "perceive", tmp_path / "bare.npz", "--out", tmp_path / "out", "--json", capsys=capsys
    )
    assert code == 0
    assert json.loads((tmp_path / "out" / "scene.json").read_text())["frame"] == "camera"
    camera = SAMPLE.with_suffix(".json")
    shutil.copy(SAMPLE, tmp_path / "d.png")
    code, again, _ = run(
        "perceive",
        tmp_path / "d.png",
        "--camera",
        camera,
        "--out",
        tmp_path / "o2",
        "--json",
        capsys=capsys,
    )
    assert code == 0
    assert json.loads(again)["rows"][0]["objects"] == json.loads(out)["rows"][0]["objects"]


def test_perceive_reads_a_recording_frame_by_frame(tmp_path, capsys):
    frame = read_frame(SAMPLE)
    bare = DepthFrame(frame.depth, frame.intrinsics)
    write_ros_frames(tmp_path / "two.mcap", [bare, bare])
    code, out, _ = run(
        "perceive", tmp_path / "two.mcap", "--out", tmp_path / "out", "--json", capsys=capsys
    )
    assert code == 0
    assert json.loads(out)["frames"] == 2
    assert (tmp_path / "out" / "0001" / "scene.json").is_file()


def test_missing_camera_gives_one_line_and_exit_code_1_within_two_seconds():
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "eyehand.apps", "perceive", "--oak"],
        capture_output=True,
        text=True,
        env={**os.environ, "DEPTHAI_LEVEL": ""},
        check=False,
    )
    # The limit is 2 s after start-up. A loaded machine needs several seconds for the imports.
    assert time.perf_counter() - began < 8.0
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("eyehand: ")
    assert len(done.stderr.strip().splitlines()) == 1


def test_perceive_finds_all_objects_of_synth(tmp_path, capsys):
    code, out, _ = run(
        "synth", "--seed", "3", "--objects", "3", "--out", tmp_path, "--json", capsys=capsys
    )
    assert code == 0
    report = json.loads(out)
    assert report["seed"] == 3
    assert len(report["rows"]) == 3
    truth = json.loads((tmp_path / "ground_truth.json").read_text())
    assert len(truth["objects"]) == 3
    code, out, _ = run(
        "perceive", tmp_path / "depth.png", "--out", tmp_path / "p", "--json", capsys=capsys
    )
    assert json.loads(out)["rows"][0]["objects"] == 3


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".npz", ".xyz"])
def test_fit_reads_clouds_and_writes_the_solid(tmp_path, capsys, suffix, flat):
    cloud = cloud_file(tmp_path / f"ball{suffix}")
    code, out, _ = run("fit", cloud, "--out", tmp_path / "out", "--json", capsys=capsys)
    assert code == 0
    solid = json.loads(out)["rows"][0]["solid"]
    assert solid["kind"] == "sphere"
    assert np.allclose(solid["semi_axes_m"], 0.04, atol=5e-4)
    assert np.allclose(solid["position_m"], [0.1, 0.2, 0.3], atol=5e-4)
    assert (tmp_path / "out" / "ball_solid.ply").stat().st_size > 1000
    report = json.loads((tmp_path / "out" / "ball_solid.json").read_text())
    assert report["schema"] == "eyehand.solid/1"


def test_fit_reports_which_of_several_clouds_failed(tmp_path, capsys):
    good = cloud_file(tmp_path / "good.ply")
    (tmp_path / "few.xyz").write_text("0 0 0\n0 0 1\n0 1 0\n")
    code, out, _ = run(
        "fit", good, tmp_path / "few.xyz", "--kind", "ellipsoid", "--json", capsys=capsys
    )
    assert code == 1
    first, second = json.loads(out)["rows"]
    assert first["solid"]["kind"] == "ellipsoid"
    assert not second["converged"]
    assert "too few" in second["reason"]


def test_fit_does_not_overwrite_a_cloud_or_another_result(tmp_path, capsys, flat):
    cloud = cloud_file(tmp_path / "ball.ply")
    before = cloud.read_bytes()
    assert run("fit", cloud, "--out", tmp_path, capsys=capsys)[0] == 0
    assert cloud.read_bytes() == before
    other = cloud_file(tmp_path / "ball.xyz")
    code, _, err = run("fit", cloud, other, "--out", tmp_path / "o", capsys=capsys)
    assert code == 2
    assert "same name" in err


def test_brackets_in_file_names_are_printed(tmp_path, capsys):
    cloud = cloud_file(tmp_path / "cup[left].xyz")
    assert "cup[left].xyz" in run("fit", cloud, capsys=capsys)[1]
    frame = small_frame(tmp_path / "[bold]x.npz", np.ones((16, 20), np.float32))
    table = run("perceive", frame, "--out", tmp_path / "o", capsys=capsys)[1]
    assert "[bold]x.npz" in table.replace("\n", "")  # long titles wrap


def test_wide_frame_is_perceived(tmp_path, capsys):
    frame = small_frame(tmp_path / "wide.npz", np.ones((18, 64), np.float32))
    assert run("perceive", frame, "--out", tmp_path / "o", capsys=capsys)[0] == 0
    assert picture(tmp_path / "o" / "overlay.png").ndim == 3


def small_frame(path: Path, depth: np.ndarray) -> Path:
    height, width = depth.shape
    write_frame(path, DepthFrame(depth, CameraIntrinsics(50.0, 50.0, 9.5, 7.5, width, height)))
    return path


BAD = {
    "missing file": (["perceive", "nowhere.png"], "nowhere.png"),
    "no frame": (["perceive"], "--oak"),
    "both": (["perceive", "x.png", "--oak"], "either"),
    "record without camera": (["perceive", "x.png", "--record", "r.mcap"], "--record"),
    "frames": (["perceive", "x.png", "--frames", "0"], "--frames"),
    "unknown suffix": (["perceive", "scene.blend"], ".ply, .mcap"),
    "unknown option": (["perceive", "x.png", "--nonsense"], "nonsense"),
    "unknown command": (["grab"], "grab"),
    "wrong type": (["synth", "--seed", "three"], "three"),
    "wrong choice": (["fit", "a.ply", "--kind", "cone"], "cone"),
    "too many objects": (["synth", "--objects", "16"], "16"),
    "no cloud": (["fit"], "CLOUD"),
    "bad noise": (["fit", "a.ply", "--noise-mm", "-1"], "--noise-mm"),
    "endless noise": (["fit", "a.ply", "--noise-mm", "inf"], "--noise-mm"),
    "frames of a file": (["perceive", "x.png", "--frames", "3"], "--frames"),
    "bad purpose": (["demo", "--purpose", "juggle"], "juggle"),
    "no scene": (["demo", "--scene", "crowded"], "crowded"),
    "crowd": (["demo", "--objects", "16"], "--objects"),
    "negative seed": (["demo", "--seed", "-1"], "--seed"),
    "robot without hand": (["demo", "--robot", "r.xml"], "--hand-frame"),
    "unknown arm": (["demo", "--arm", "pand"], "did you mean panda?"),
    "arm without hand": (["demo", "--arm", "ur5e"], "--hand panda, 2f85"),
    "mount alone": (["demo", "--mount", "0 0 0 0 0 0"], "--mount needs --arm and --hand"),
    "no robot": (["demo", "--robot", "r.xml", "--hand-frame", "palm"], "r.xml"),
    "scene without truth": (["demo", "--scene", "."], "ground_truth.json"),
}


@pytest.mark.parametrize("case", BAD)
def test_invalid_input_gives_one_line_and_exit_code_2(case, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, names = BAD[case]
    code, out, err = run(*arguments, capsys=capsys)
    assert code == 2
    assert out == ""
    assert err.startswith("eyehand: ")
    assert names in err
    assert len(err.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_frame_without_objects_gives_an_empty_scene(tmp_path, capsys):
    frame = small_frame(tmp_path / "wall.npz", np.ones((16, 20), np.float32))
    code, out, _ = run("perceive", frame, "--out", tmp_path / "o", "--json", capsys=capsys)
    assert code == 0
    assert json.loads(out)["rows"][0]["objects"] == 0


def test_impossible_output_folder_is_rejected(tmp_path, capsys):
    (tmp_path / "file").write_text("in the way")
    code, _, err = run("perceive", SAMPLE, "--out", tmp_path / "file" / "out", capsys=capsys)
    assert code == 2
    assert "cannot create the folder" in err


def test_help_is_fast_and_names_every_command():
    command = [sys.executable, "-m", "eyehand.apps", "--help"]
    times = []
    for _ in range(3):
        began = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        times.append(time.perf_counter() - began)
        assert all(name in done.stdout for name in COMMANDS)
    assert min(times) < 0.5


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_has_help(command, capsys):
    code, out, _ = run(*command.split(), "--help", capsys=capsys)
    assert code == 0
    # The doctor writes no file.
    assert ("--out" in out) == (command != "doctor")

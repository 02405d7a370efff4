"""Bad frames: one line that names the file, exit code 2, and no file is written."""

import json
import os
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from eyehand.apps import grasp_command, perceive
from eyehand.apps.main import main
from eyehand.perception import CameraIntrinsics, DepthFrame, write_frame

SHAPE = (120, 160)
CAMERA = {"fx": 130.0, "fy": 130.0, "cx": 79.5, "cy": 59.5}
RNG = np.random.default_rng(0)
WALL = 1.0 + 0.001 * RNG.standard_normal(SHAPE)
DEPTHS = {
    "NaN": (np.full(SHAPE, np.nan), "0 everywhere"),
    "no readings": (np.zeros(SHAPE), "0 everywhere"),
    "noise": (RNG.uniform(0.5, 2.0, SHAPE), "the readings are noise"),
    "constant": (np.ones(SHAPE), "all readings are 1.000 m"),
}
CAMERAS = {
    "cx outside": ({"cx": 500.0}, "is not inside the image"),
    "cx negative": ({"cx": -5.0}, "is not inside the image"),
    "cy outside": ({"cy": -1.0}, "is not inside the image"),
    "huge fx": ({"fx": 1e300}, "focal lengths must be"),
}


def refused(*arguments: object, capsys: pytest.CaptureFixture[str]) -> str:
    """Run a command that must fail with code 2, and return its only line."""
    with pytest.raises(SystemExit) as exit_info:
        main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    assert exit_info.value.code == 2
    assert printed.out == ""
    lines = printed.err.strip().splitlines()
    assert len(lines) == 1
    return lines[0]


def archive(path: Path, depth: np.ndarray = WALL, **changed: float) -> Path:
    """Write a frame without the checks of `write_frame`, with labels for an evaluation."""
    intrinsics = [float(value) for value in (CAMERA | changed).values()]
    np.savez(
        path, depth=depth.astype(np.float32), intrinsics=intrinsics, label=np.zeros(SHAPE, int)
    )
    return path


@pytest.mark.parametrize(
    ("depth", "changed", "message"),
    [
        *((depth, {}, message) for depth, message in DEPTHS.values()),
        *((WALL, changed, message) for changed, message in CAMERAS.values()),
    ],
    ids=[*DEPTHS, *CAMERAS],
)
def test_frame_that_shows_no_scene_is_refused(
    depth: np.ndarray,
    changed: dict[str, float],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = archive(tmp_path / "a.npz", depth, **changed)
    out = tmp_path / "out"
    for command in (
        ("perceive", path),
        ("grasp", path, "--hand", "panda"),
        ("evaluate", "segmentation", "--dataset", tmp_path, "--worst", 0),
        ("fit", path, "--label", 1),
    ):
        line = refused(*command, "--out", out, capsys=capsys)
        assert message in line
        assert "a" in line
    assert not (out / "scene.json").exists()


@pytest.mark.parametrize("command", [perceive, grasp_command], ids=["perceive", "grasp"])
def test_constant_image_is_refused_before_the_kernels_load(
    command: ModuleType,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(command, "load_kernels", lambda: pytest.fail("the kernels were loaded"))
    path = archive(tmp_path / "a.npz", np.ones(SHAPE))
    options = ("--hand", "panda") if command is grasp_command else ()
    name = "grasp" if command is grasp_command else "perceive"
    line = refused(name, path, *options, "--out", tmp_path / "out", capsys=capsys)
    assert "all readings are 1.000 m" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "command", ["perceive", "grasp --hand panda", "evaluate segmentation --dataset"]
)
def test_long_name_is_refused(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(*command.split(), "a" * 296 + ".png", capsys=capsys)
    assert "File name too long" in line


@pytest.mark.parametrize("suffix", [".png", ".npz", ".pcd", ".ply", ".mcap"])
def test_fifo_is_refused(suffix: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / f"a{suffix}"
    os.mkfifo(path)
    for command in (("perceive",), ("grasp", "--hand", "panda")):
        assert "it is a FIFO" in refused(*command, path, capsys=capsys)


def test_bad_files_of_annotated_frames_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "one"
    folder.mkdir()
    camera = CameraIntrinsics(**CAMERA, width=SHAPE[1], height=SHAPE[0])
    write_frame(folder / "depth.png", DepthFrame(WALL.astype(np.float32), camera))
    os.mkfifo(folder / "points.json")
    command = ("evaluate", "segmentation", "--points", tmp_path, "--out", tmp_path / "out")
    assert "points.json: cannot be read" in refused(*command, capsys=capsys)
    (folder / "points.json").unlink()
    (folder / "points.json").write_text(json.dumps({"objects": []}))
    noise = RNG.uniform(0.5, 2.0, SHAPE).astype(np.float32)
    write_frame(folder / "depth.png", DepthFrame(noise, camera))
    assert "one: the readings are noise" in refused(*command, capsys=capsys)


def test_line_break_in_a_name_keeps_the_message_on_one_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert "no such file" in refused("perceive", "a\nb.png", capsys=capsys)


def test_removed_current_folder_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    with pytest.raises(SystemExit) as exit_info:
        main(["doctor"])
    assert exit_info.value.code == 2
    assert "the current folder was removed" in capsys.readouterr().err

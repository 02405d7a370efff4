"""Tests of frame file sequences: selection, order and error messages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.cameras import Camera, FileSequence
from eyehand.perception.cameras.file_sequence import natural_key
from eyehand.perception.io.depth_frame import write_frame
from eyehand.perception.io.intrinsics import write_intrinsics

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.perception.frame import CameraIntrinsics, DepthFrame

    Frames = Callable[..., list[DepthFrame]]


@pytest.fixture
def folder(tmp_path: Path, frames: Frames) -> Path:
    """Return a folder of eleven frames whose numbers sort differently as text."""
    for number, frame in enumerate(frames(11)):
        write_frame(tmp_path / f"frame{number}.npz", frame)
    return tmp_path


def test_folder_is_read_in_natural_order(folder: Path, frames: Frames) -> None:
    sequence = FileSequence(folder)

    assert isinstance(sequence, Camera)
    assert [p.name for p in sequence.paths] == [f"frame{i}.npz" for i in range(11)]
    assert len(sequence) == 11
    for read, written in zip(sequence.frames(), frames(11), strict=True):
        assert np.array_equal(read.depth, written.depth)
        assert read.intrinsics == written.intrinsics


def test_sequence_can_be_read_twice(folder: Path) -> None:
    sequence = FileSequence(folder)

    assert len(list(sequence.frames())) == len(list(sequence.frames())) == 11


def test_pattern_selects_files(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert [p.name for p in FileSequence(str(folder / "frame?.npz")).paths][-1] == "frame9.npz"
    assert [p.name for p in FileSequence(folder / "frame1*").paths] == ["frame1.npz", "frame10.npz"]
    assert len(FileSequence(str(folder.parent / "**" / f"{folder.name}/*.npz"))) == 11

    monkeypatch.chdir(folder)
    assert FileSequence("*10.npz").paths == (Path("frame10.npz"),)


def test_existing_file_with_brackets_is_no_pattern(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "frame[1].npz"
    write_frame(path, frames(1)[0])

    assert FileSequence(path).paths == (path,)


def test_listed_files_are_sorted_naturally(folder: Path) -> None:
    as_text = sorted(str(p) for p in folder.iterdir())

    assert as_text[1].endswith("frame1.npz")
    assert as_text[2].endswith("frame10.npz")
    assert FileSequence(as_text).paths == FileSequence(folder).paths


def test_single_file_is_sequence_of_one(folder: Path) -> None:
    assert len(list(FileSequence(folder / "frame3.npz").frames())) == 1


def test_colour_and_camera_files_are_no_frames(tmp_path: Path, frames: Frames) -> None:
    for number, frame in enumerate(frames(2, colour=True)):
        write_frame(tmp_path / f"f{number}.png", frame)
    write_frame(tmp_path / ".f9.npz", frames(1)[0])
    (tmp_path / "notes.txt").write_text("none of these")

    for source in (tmp_path, str(tmp_path / "*"), tmp_path.glob("f*.png")):
        sequence = FileSequence(source)
        assert [p.name for p in sequence.paths] == ["f0.png", "f1.png"]
        assert all(frame.colour is not None for frame in sequence.frames())


def test_lone_depth_image_named_like_colour_is_read(tmp_path: Path, frames: Frames) -> None:
    write_frame(tmp_path / "no_colour.npz", frames(1)[0])

    assert len(list(FileSequence(tmp_path).frames())) == 1


def test_colour_image_beside_depth_is_no_frame(tmp_path: Path, frames: Frames) -> None:
    write_frame(tmp_path / "depth.npz", frames(1)[0])
    (tmp_path / "color.png").write_bytes(b"never opened")

    assert [p.name for p in FileSequence(tmp_path).paths] == ["depth.npz"]


def test_one_camera_file_applies_to_all_frames(
    tmp_path: Path, frames: Frames, camera: CameraIntrinsics
) -> None:
    for number, frame in enumerate(frames(2)):
        write_frame(tmp_path / f"f{number}.png", frame)
        (tmp_path / f"f{number}.json").unlink()
    camera_file = tmp_path / "calibration" / "d435.json"
    camera_file.parent.mkdir()
    write_intrinsics(camera_file, camera)

    read = list(FileSequence(tmp_path, camera=camera_file).frames())

    assert [frame.intrinsics for frame in read] == [camera, camera]


def test_missing_files_are_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.npz: no such file"):
        FileSequence(tmp_path / "nothing.npz")
    with pytest.raises(InputError, match=r"holds no depth frame files, expected some of \.png"):
        FileSequence(tmp_path)
    with pytest.raises(InputError, match="holds no depth frame files"):
        FileSequence(str(tmp_path / "*.npz"))
    with pytest.raises(InputError, match="at least one file"):
        FileSequence([])


def test_broken_file_is_reported_when_read(folder: Path) -> None:
    (folder / "frame1.npz").write_bytes(b"no archive")
    stream = FileSequence(folder).frames()

    next(stream)
    with pytest.raises(InputError, match=r"frame1\.npz"):
        next(stream)


@given(numbers=st.lists(st.integers(0, 10**9), unique=True, min_size=1))
def test_numbers_sort_by_value(numbers: list[int]) -> None:
    paths = [Path(f"run2/f{n}.npz") for n in numbers]

    assert sorted(paths, key=natural_key) == [Path(f"run2/f{n}.npz") for n in sorted(numbers)]


def test_names_without_numbers_sort_alphabetically() -> None:
    names = ["b.npz", "a10.npz", "a.npz", "a9b2.npz", "a9b.npz", "9.npz", "10.npz"]

    ordered = [p.name for p in sorted(map(Path, names), key=natural_key)]

    assert ordered == ["9.npz", "10.npz", "a.npz", "a9b.npz", "a9b2.npz", "a10.npz", "b.npz"]

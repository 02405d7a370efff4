"""Tests of the recorder: a complete recording or none."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import numpy as np
import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.perception.cameras import OakRecording
from eyehand.perception.cameras.oak_recorder import OakRecorder
from eyehand.perception.frame import DepthFrame

from .oak_frames import image_messages, record_frames

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    Frames = Callable[..., list[DepthFrame]]


def test_frames_sent_at_once_are_all_recorded(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(60)

    assert record_frames(tmp_path / "scene.mcap", iter(recorded)) == 60
    played = list(OakRecording(tmp_path / "scene.mcap").frames())

    assert len(played) == 60
    assert np.array_equal(played[-1].depth, recorded[-1].depth)


def test_mixed_colour_frames_are_rejected(tmp_path: Path, frames: Frames) -> None:
    grey, coloured = frames(2), frames(2, colour=True)

    with pytest.raises(InputError, match="frame 1: it has a colour image, the frames before"):
        record_frames(tmp_path / "scene.mcap", [grey[0], coloured[1]])
    with pytest.raises(InputError, match="frame 1: it has no colour image, the frames before"):
        record_frames(tmp_path / "scene.mcap", [coloured[0], grey[1]])
    assert list(tmp_path.iterdir()) == []


def test_failing_source_keeps_old_recording(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    record_frames(path, frames(2))
    before = path.read_bytes()

    def failing() -> Iterator[DepthFrame]:
        yield from frames(5)
        raise DeviceError("the camera fell silent")

    with pytest.raises(DeviceError, match="fell silent"):
        record_frames(path, failing())
    assert [p.name for p in tmp_path.iterdir()] == ["scene.mcap"]
    assert path.read_bytes() == before


def test_recording_without_colour_removes_old_colour_file(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    record_frames(path, frames(2, colour=True))
    record_frames(path, frames(2))

    assert [p.name for p in tmp_path.iterdir()] == ["scene.mcap"]
    assert all(f.colour is None for f in OakRecording(path).frames())


def test_recording_can_overwrite_its_source(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    recorded = frames(20)
    record_frames(path, recorded)

    assert record_frames(path, OakRecording(path).frames()) == 20
    played = list(OakRecording(path).frames())
    assert all(np.array_equal(a.depth, b.depth) for a, b in zip(recorded, played, strict=True))


@pytest.mark.parametrize(
    ("name", "message"),
    [("scene.mp4", "must end in .mcap"), ("no/scene.mcap", "there is no folder")],
)
def test_invalid_file_name_is_rejected_at_once(tmp_path: Path, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        OakRecorder(tmp_path / name)


def test_removed_folder_raises_device_error(
    tmp_path: Path, frames: Frames, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "usb-stick"
    folder.mkdir()
    recorder = OakRecorder(folder / "scene.mcap")
    shutil.rmtree(folder)
    try:
        recorder.write(*image_messages(frames(1)[0], 0.0))
        with pytest.raises(DeviceError, match=r"cannot record .*is the disk full"):
            recorder.finish()
    finally:
        recorder.discard()
    assert capfd.readouterr() == ("", "")

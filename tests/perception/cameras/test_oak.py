"""Tests of the live OAK camera without a device. The host part of the pipeline is real."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
import pytest

from eyehand.errors import DeviceError, InputError
from eyehand.perception.cameras import Camera, OakCamera, OakOptions, RosRecording, RosWriter
from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak import PRESETS, live_frames
from eyehand.perception.cameras.oak_message import COLOUR, DEPTH
from eyehand.perception.cameras.ros_frames import recorded

from .oak_frames import image_messages

if TYPE_CHECKING:
    from collections.abc import Callable, Generator
    from pathlib import Path

    from scipy.spatial.transform import RigidTransform

    from eyehand.perception.frame import DepthFrame

    Frames = Callable[..., list[DepthFrame]]

load_depthai()
import depthai as dai  # noqa: E402 - depthai prints to stdout unless load_depthai came first

NO_DEVICE = """
import time
from eyehand.errors import DeviceError
from eyehand.perception.cameras import OakCamera, OakOptions
started = time.monotonic()
try:
    OakCamera(OakOptions(device="no-such-camera")).frames()
except DeviceError as error:
    print(error)
    print(time.monotonic() - started)
"""


def queue_of(frames: list[DepthFrame]) -> dai.MessageQueue:
    """Return a queue with the messages that the device would send."""
    queue = dai.MessageQueue("pairs", 64, True)
    for number, frame in enumerate(frames):
        depth, colour = image_messages(frame, number / 30)
        pair = dai.MessageGroup()
        pair[DEPTH] = depth
        if colour is not None:
            pair[COLOUR] = colour
        queue.send(pair)
    return queue


def empty_pair(frame: DepthFrame) -> dai.MessageGroup:
    depth, _ = image_messages(frame, 0.0)
    depth.setData(bytes(2 * frame.depth.size))
    pair = dai.MessageGroup()
    pair[DEPTH] = depth
    return pair


def test_missing_camera_is_reported_in_one_line_within_two_seconds() -> None:
    process = subprocess.run(
        [sys.executable, "-c", NO_DEVICE], capture_output=True, text=True, timeout=60, check=True
    )

    error, seconds = process.stdout.splitlines()
    assert re.match("no OAK camera (found: connect one|'no-such-camera' found, only )", error)
    assert float(seconds) < 2.0
    assert process.stderr == ""


def test_no_camera_leaves_no_recording(tmp_path: Path) -> None:
    camera = OakCamera(OakOptions(device="no-such-camera"), record=tmp_path / "scene.mcap")

    assert isinstance(camera, Camera)
    with pytest.raises(DeviceError, match="no OAK camera"):
        camera.frames()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "message"),
    [("scene.mp4", "must end in .mcap"), ("no/scene.mcap", "there is no folder")],
)
def test_unwritable_recording_is_rejected_before_camera_search(
    tmp_path: Path, name: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        OakCamera(record=tmp_path / name).frames()


def test_failing_disk_leaves_the_old_recording(
    tmp_path: Path, frames: Frames, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "scene.mcap"
    path.write_bytes(b"old")
    stream = recorded(live_frames(queue_of(frames(3)), 1.0), path)
    next(stream)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(RosWriter, "write", full)
    with pytest.raises(DeviceError, match="No space left on device"):
        next(stream)
    assert [one.name for one in tmp_path.iterdir()] == ["scene.mcap"]
    assert path.read_bytes() == b"old"


def test_live_pairs_become_frames(frames: Frames) -> None:
    sent = frames(3, colour=True)

    for before, after in zip(sent, live_frames(queue_of(sent), 1.0), strict=False):
        assert np.array_equal(before.depth, after.depth)
        assert before.colour is not None
        assert after.colour is not None
        assert np.array_equal(before.colour, after.colour)
        assert after.T_world_camera is None


@pytest.mark.parametrize("colour", [True, False])
def test_recording_equals_live_frames(
    tmp_path: Path, frames: Frames, pose: RigidTransform, colour: bool
) -> None:
    path = tmp_path / "scene.mcap"
    stream = recorded(live_frames(queue_of(frames(6, colour=colour)), 1.0, pose), path)

    live_frames_read = list(islice(stream, 4))
    assert not path.exists()
    stream.close()
    played = list(RosRecording(path).frames())

    assert len(live_frames_read) == len(played) == 4
    for live, later in zip(live_frames_read, played, strict=True):
        assert np.array_equal(live.depth, later.depth)
        assert live.intrinsics == later.intrinsics
        assert later.T_world_camera is not None
        np.testing.assert_allclose(later.T_world_camera.as_matrix(), pose.as_matrix(), atol=1e-14)
        if live.colour is None or later.colour is None:
            assert not colour
        else:
            assert np.array_equal(live.colour, later.colour)


def test_silent_camera_ends_stream_and_keeps_recording(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    stream = recorded(live_frames(queue_of(frames(2)), 0.2), path)

    next(stream)
    next(stream)
    started = time.monotonic()
    with pytest.raises(DeviceError, match=r"sent nothing for 0\.2 s: is it still connected"):
        next(stream)

    assert time.monotonic() - started < 2.0
    assert len(list(RosRecording(path).frames())) == 2


@pytest.mark.parametrize("fault", [KeyboardInterrupt(), InputError("a rotated image")])
def test_interrupted_stream_keeps_recording_and_is_closed(
    tmp_path: Path, frames: Frames, fault: BaseException
) -> None:
    path, closed = tmp_path / "scene.mcap", []

    def broken() -> Generator[DepthFrame, None, None]:
        try:
            yield from frames(2)
            raise fault
        finally:
            closed.append(True)

    with pytest.raises(type(fault)):
        list(recorded(broken(), path))
    assert closed == [True]
    assert len(list(RosRecording(path).frames())) == 2


def test_stopped_reader_closes_stream(tmp_path: Path, frames: Frames) -> None:
    closed = []

    def endless() -> Generator[DepthFrame, None, None]:
        try:
            while True:
                yield from frames(1)
        finally:
            closed.append(True)

    stream = recorded(endless(), tmp_path / "scene.mcap")
    next(stream)
    stream.close()
    assert closed == [True]


def test_unplugged_camera_ends_stream(frames: Frames) -> None:
    queue = queue_of(frames(1))
    stream = live_frames(queue, 30.0)
    next(stream)
    queue.close()

    started = time.monotonic()
    with pytest.raises(DeviceError, match="sent nothing"):
        next(stream)
    assert time.monotonic() - started < 1.0


def test_images_without_reading_are_skipped(frames: Frames) -> None:
    (frame,) = frames(1)
    queue = dai.MessageQueue("pairs", 64, True)
    queue.send(empty_pair(frame))
    queue.send(empty_pair(frame))
    pair = dai.MessageGroup()
    pair[DEPTH] = image_messages(frame, 0.0)[0]
    queue.send(pair)

    assert np.array_equal(next(live_frames(queue, 1.0)).depth, frame.depth)


def test_covered_lens_is_reported_separately(frames: Frames) -> None:
    queue = dai.MessageQueue("pairs", 64, True)
    queue.send(empty_pair(frames(1)[0]))

    with pytest.raises(DeviceError, match=r"no depth anywhere in 1 images.*lens covered"):
        next(live_frames(queue, 0.2))


def test_stream_without_frames_leaves_no_recording(tmp_path: Path, frames: Frames) -> None:
    with pytest.raises(DeviceError):
        next(recorded(live_frames(queue_of([]), 0.1), tmp_path / "scene.mcap"))

    assert list(tmp_path.iterdir()) == []


def test_message_without_image_is_rejected() -> None:
    queue = dai.MessageQueue("pairs", 4, True)
    pair = dai.MessageGroup()
    pair[DEPTH] = dai.IMUData()
    queue.send(pair)

    with pytest.raises(InputError, match="depth stream holds IMUData messages, expected images"):
        next(live_frames(queue, 1.0))


def test_presets_equal_depthai_presets() -> None:
    members = dai.node.StereoDepth.PresetMode.__members__

    assert sorted(PRESETS) == sorted(name.lower() for name in members)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"width": 0}, "image size must be >= 1 px, got 0x400"),
        ({"height": -2}, "640x-2"),
        ({"fps": 0.0}, "must be > 0, got 0.0 fps"),
        ({"timeout_s": float("nan")}, "must be > 0"),
        ({"preset": "best"}, "no stereo preset 'best': must be one of"),
    ],
)
def test_options_out_of_range_are_rejected(options: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        OakOptions(**options)

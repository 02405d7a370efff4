"""The live camera without one: no device is told at once, and the host's part is the real one."""

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
from eyehand.perception.cameras import Camera, OakCamera, OakOptions, OakRecording
from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak import PRESETS, live_frames
from eyehand.perception.cameras.oak_message import image_messages
from eyehand.perception.cameras.oak_recorder import OakRecorder
from eyehand.perception.cameras.oak_stream import COLOUR, DEPTH

if TYPE_CHECKING:
    from collections.abc import Callable
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
    """Fill a queue with what the device part of the pipeline would have sent."""
    queue = dai.MessageQueue("pairs", 64, True)
    for number, frame in enumerate(frames):
        depth, colour = image_messages(frame, number / 30)
        pair = dai.MessageGroup()
        pair[DEPTH] = depth
        if colour is not None:
            pair[COLOUR] = colour
        queue.send(pair)
    return queue


def dark_pair(frame: DepthFrame) -> dai.MessageGroup:
    depth, _ = image_messages(frame, 0.0)
    depth.setData(bytes(2 * frame.depth.size))
    pair = dai.MessageGroup()
    pair[DEPTH] = depth
    return pair


def test_no_camera_is_told_in_one_line_within_two_seconds_and_nothing_else() -> None:
    run = subprocess.run(
        [sys.executable, "-c", NO_DEVICE], capture_output=True, text=True, timeout=60, check=True
    )

    message, seconds = run.stdout.splitlines()
    assert re.match("no OAK camera (found: connect one|'no-such-camera' found, only )", message)
    assert float(seconds) < 2.0
    assert run.stderr == ""


def test_no_camera_leaves_no_recording(tmp_path: Path) -> None:
    camera = OakCamera(OakOptions(device="no-such-camera"), record=tmp_path / "scene.mcap")

    assert isinstance(camera, Camera)
    with pytest.raises(DeviceError, match="no OAK camera"):
        camera.frames()
    assert list(tmp_path.iterdir()) == []


def test_a_recording_that_cannot_be_written_is_told_before_the_camera_is_sought(
    tmp_path: Path,
) -> None:
    with pytest.raises(InputError, match="there is no folder"):
        OakCamera(record=tmp_path / "no" / "scene.mcap").frames()


def test_live_pairs_become_frames(frames: Frames) -> None:
    sent = frames(3, colour=True)

    for before, after in zip(sent, live_frames(queue_of(sent), 1.0), strict=False):
        assert np.array_equal(before.depth, after.depth)
        assert before.colour is not None
        assert after.colour is not None
        assert np.array_equal(before.colour, after.colour)
        assert after.T_world_camera is None


@pytest.mark.parametrize("colour", [True, False])
def test_what_was_seen_live_is_what_was_recorded(
    tmp_path: Path, frames: Frames, pose: RigidTransform, colour: bool
) -> None:
    path = tmp_path / "scene.mcap"
    stream = live_frames(queue_of(frames(6, colour=colour)), 1.0, OakRecorder(path), pose)

    seen = list(islice(stream, 4))
    assert not path.exists()
    stream.close()
    played = list(OakRecording(path).frames())

    assert len(seen) == len(played) == 4
    for live, later in zip(seen, played, strict=True):
        assert np.array_equal(live.depth, later.depth)
        assert live.intrinsics == later.intrinsics
        assert live.T_world_camera is not None
        assert later.T_world_camera is not None
        np.testing.assert_array_equal(
            live.T_world_camera.as_matrix(), later.T_world_camera.as_matrix()
        )
        np.testing.assert_allclose(live.T_world_camera.as_matrix(), pose.as_matrix(), atol=1e-6)
        if live.colour is None or later.colour is None:
            assert not colour
        else:
            assert np.array_equal(live.colour, later.colour)


def test_a_camera_that_falls_silent_ends_the_stream_and_keeps_the_recording(
    tmp_path: Path, frames: Frames
) -> None:
    path = tmp_path / "scene.mcap"
    stream = live_frames(queue_of(frames(2)), 0.2, OakRecorder(path))

    next(stream)
    next(stream)
    started = time.monotonic()
    with pytest.raises(DeviceError, match=r"sent nothing for 0\.2 s: is it still connected"):
        next(stream)

    assert time.monotonic() - started < 2.0
    assert len(OakRecording(path)) == 2


def test_a_camera_that_is_unplugged_ends_the_stream(frames: Frames) -> None:
    queue = queue_of(frames(1))
    stream = live_frames(queue, 30.0)
    next(stream)
    queue.close()

    started = time.monotonic()
    with pytest.raises(DeviceError, match="sent nothing"):
        next(stream)
    assert time.monotonic() - started < 1.0


def test_images_without_any_reading_are_passed_over(tmp_path: Path, frames: Frames) -> None:
    (seen,) = frames(1)
    queue = dai.MessageQueue("pairs", 64, True)
    queue.send(dark_pair(seen))
    queue.send(dark_pair(seen))
    pair = dai.MessageGroup()
    pair[DEPTH] = image_messages(seen, 0.0)[0]
    queue.send(pair)
    stream = live_frames(queue, 1.0, OakRecorder(tmp_path / "scene.mcap"))

    assert np.array_equal(next(stream).depth, seen.depth)
    stream.close()
    assert len(OakRecording(tmp_path / "scene.mcap")) == 1


def test_a_covered_lens_is_told_apart_from_silence(frames: Frames) -> None:
    queue = dai.MessageQueue("pairs", 64, True)
    queue.send(dark_pair(frames(1)[0]))

    with pytest.raises(DeviceError, match=r"no depth anywhere in 1 images.*lens covered"):
        next(live_frames(queue, 0.2))


def test_a_stream_left_before_its_first_frame_leaves_no_recording(
    tmp_path: Path, frames: Frames
) -> None:
    with pytest.raises(DeviceError):
        next(live_frames(queue_of([]), 0.1, OakRecorder(tmp_path / "scene.mcap")))

    assert list(tmp_path.iterdir()) == []


def test_another_message_than_an_image_is_refused() -> None:
    queue = dai.MessageQueue("pairs", 4, True)
    pair = dai.MessageGroup()
    pair[DEPTH] = dai.IMUData()
    queue.send(pair)

    with pytest.raises(InputError, match="depth stream holds IMUData messages, expected images"):
        next(live_frames(queue, 1.0))


def test_the_presets_are_those_of_depthai() -> None:
    members = dai.node.StereoDepth.PresetMode.__members__

    assert sorted(PRESETS) == sorted(name.lower() for name in members)


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ({"width": 0}, "image size must be >= 1 px, got 0x400"),
        ({"height": -2}, "640x-2"),
        ({"fps": 0.0}, "must be > 0, got 0.0 fps"),
        ({"timeout_s": float("nan")}, "must be > 0"),
        ({"preset": "best"}, "no stereo preset 'best': must be one of"),
    ],
)
def test_options_out_of_range_are_refused(options: dict, fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        OakOptions(**options)

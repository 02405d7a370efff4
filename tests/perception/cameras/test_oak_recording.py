"""Tests of recordings: exact round trip, order, and damaged files."""

from __future__ import annotations

import struct
import time
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.cameras import Camera, OakRecording
from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak_recorder import colour_path
from eyehand.perception.frame import CameraIntrinsics, DepthFrame

from .oak_frames import record_frames

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.spatial.transform import RigidTransform

    Frames = Callable[..., list[DepthFrame]]

LZ4_MAGIC = b"\x04\x22\x4d\x18"
"""First bytes of every compressed chunk of a recording."""


def test_depth_round_trips_exactly_and_in_order(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(9)

    assert record_frames(tmp_path / "scene.mcap", recorded) == 9
    recording = OakRecording(tmp_path / "scene.mcap")
    played = list(recording.frames())

    assert isinstance(recording, Camera)
    assert len(recording) == len(played) == 9
    for before, after in zip(recorded, played, strict=True):
        assert np.array_equal(before.depth, after.depth)
        assert after.depth.dtype == np.float32
        assert after.colour is None


def test_depth_is_rounded_to_millimetres(tmp_path: Path, camera: CameraIntrinsics) -> None:
    depth = np.full((camera.height, camera.width), 0.7004, dtype=np.float32)
    depth[0, :3] = (0.0, 0.0006, 65.5349)

    record_frames(tmp_path / "scene.mcap", [DepthFrame(depth, camera)])
    (played,) = OakRecording(tmp_path / "scene.mcap").frames()

    assert played.depth[0, :3].tolist() == np.array([0.0, 0.001, 65.535], np.float32).tolist()
    assert played.depth[1, 1] == np.float32(0.7)


def test_intrinsics_are_stored_in_float32(
    tmp_path: Path, frames: Frames, camera: CameraIntrinsics
) -> None:
    record_frames(tmp_path / "scene.mcap", frames(1))
    (played,) = OakRecording(tmp_path / "scene.mcap").frames()

    k = played.intrinsics
    assert (k.width, k.height) == (camera.width, camera.height)
    for name in ("fx", "fy", "cx", "cy"):
        assert getattr(k, name) == float(np.float32(getattr(camera, name)))


def test_pose_is_stored_per_frame(tmp_path: Path, frames: Frames, pose: RigidTransform) -> None:
    frames_with_pose = [
        replace(f, T_world_camera=pose if i else None) for i, f in enumerate(frames(2))
    ]

    record_frames(tmp_path / "scene.mcap", frames_with_pose)
    without_pose, with_pose = OakRecording(tmp_path / "scene.mcap").frames()

    assert without_pose.T_world_camera is None
    assert with_pose.T_world_camera is not None
    np.testing.assert_allclose(
        with_pose.T_world_camera.as_matrix(), pose.as_matrix(), rtol=0, atol=1e-6
    )


def test_colour_round_trips_exactly_with_its_depth(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(6, colour=True)
    record_frames(tmp_path / "scene.mcap", recorded)

    played = list(OakRecording(tmp_path / "scene.mcap").frames())
    without = list(OakRecording(tmp_path / "scene.mcap", colour=False).frames())

    assert sorted(p.name for p in tmp_path.iterdir()) == ["scene.colour.mcap", "scene.mcap"]
    assert all(f.colour is None for f in without)
    for before, after in zip(recorded, played, strict=True):
        assert after.colour is not None
        assert before.colour is not None
        assert np.array_equal(before.depth, after.depth)
        assert np.array_equal(before.colour, after.colour)


def test_slow_reader_gets_every_frame(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(12, colour=True)
    record_frames(tmp_path / "scene.mcap", recorded)

    played = []
    for frame in OakRecording(tmp_path / "scene.mcap").frames():
        time.sleep(0.01)
        played.append(frame)

    assert len(played) == 12
    assert all(np.array_equal(a.depth, b.depth) for a, b in zip(recorded, played, strict=True))


def test_recording_can_be_replayed_and_left_early(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(10)
    record_frames(tmp_path / "scene.mcap", recorded)
    recording = OakRecording(tmp_path / "scene.mcap")

    started = time.monotonic()
    first = list(islice(recording.frames(), 3))
    stream = recording.frames()
    next(stream)
    stream.close()

    assert time.monotonic() - started < 2.0
    assert len(first) == 3
    assert len(list(recording.frames())) == 10


def test_frames_of_different_sizes_keep_intrinsics(tmp_path: Path) -> None:
    small = DepthFrame(np.full((4, 6), 0.5, np.float32), CameraIntrinsics(5, 5, 2, 1, 6, 4))
    large = DepthFrame(np.full((8, 9), 1.5, np.float32), CameraIntrinsics(9, 8, 4, 3, 9, 8))

    record_frames(tmp_path / "scene.mcap", [small, large])
    played = list(OakRecording(tmp_path / "scene.mcap").frames())

    assert [f.intrinsics for f in played] == [small.intrinsics, large.intrinsics]


def test_missing_recording_is_reported(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nothing\.mcap: no such file"):
        OakRecording(tmp_path / "nothing.mcap")
    with pytest.raises(InputError, match="cannot be read"):
        OakRecording(tmp_path)


@pytest.mark.parametrize("content", [b"not a recording at all", b"\x89PNG\r\n\x1a\n" * 9])
def test_other_file_type_is_rejected(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "scene.mcap"
    path.write_bytes(content)

    with pytest.raises(InputError, match="not an MCAP file"):
        OakRecording(path)


def test_truncated_recording_is_rejected(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    record_frames(path, frames(3))
    whole = path.read_bytes()

    for length in (8, 50, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match="truncated"):
            OakRecording(path)


@pytest.fixture
def whole_recording(tmp_path: Path, frames: Frames) -> bytes:
    record_frames(tmp_path / "whole.mcap", frames(3))
    return (tmp_path / "whole.mcap").read_bytes()


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_changed_byte_is_detected_on_opening(
    data: st.DataObject, whole_recording: bytes, tmp_path: Path
) -> None:
    at = data.draw(st.integers(0, len(whole_recording) - 1))
    flip = data.draw(st.integers(1, 255))
    damaged = bytearray(whole_recording)
    damaged[at] ^= flip
    (tmp_path / "damaged.mcap").write_bytes(damaged)

    with pytest.raises(InputError) as caught:
        OakRecording(tmp_path / "damaged.mcap")
    assert "\n" not in str(caught.value)


def remove_seal(recording: bytes) -> bytearray:
    """Remove the checksum of the data. Recordings written by depthai have none."""
    content = bytearray(recording)
    (summary,) = struct.unpack_from("<Q", content, len(content) - 28)
    content[summary - 4 : summary] = bytes(4)
    return content


def test_unsealed_recording_plays_the_same(tmp_path: Path, frames: Frames) -> None:
    path = tmp_path / "scene.mcap"
    recorded = frames(7)
    record_frames(path, recorded)
    path.write_bytes(remove_seal(path.read_bytes()))

    for _ in range(20):
        assert len(OakRecording(path)) == 7
    played = list(OakRecording(path).frames())
    assert all(np.array_equal(a.depth, b.depth) for a, b in zip(recorded, played, strict=True))


def test_lost_images_in_unsealed_recording_are_detected_on_opening(
    tmp_path: Path, camera: CameraIntrinsics, capfd: pytest.CaptureFixture[str]
) -> None:
    slope = np.repeat(np.arange(500, 980)[:, None], 640, axis=1).astype(np.float32) / np.float32(
        1000
    )
    frames = [DepthFrame(slope, replace(camera, width=640, height=480)) for _ in range(6)]
    path = tmp_path / "scene.mcap"
    record_frames(path, frames)
    damaged = remove_seal(path.read_bytes())
    packed = damaged.index(LZ4_MAGIC, len(damaged) // 2)
    damaged[packed : packed + len(LZ4_MAGIC)] = bytes(len(LZ4_MAGIC))
    path.write_bytes(damaged)
    capfd.readouterr()

    started = time.monotonic()
    with pytest.raises(InputError, match="damaged, 4 of 6 images can be unpacked"):
        OakRecording(path, timeout_s=2.0)
    assert time.monotonic() - started < 2.0
    assert capfd.readouterr() == ("", "")


def test_colour_file_of_other_recording_is_rejected(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "a.mcap", frames(2, colour=True))
    record_frames(tmp_path / "b.mcap", frames(3, colour=True))
    colour_path(tmp_path / "b.mcap").replace(colour_path(tmp_path / "a.mcap"))

    with pytest.raises(InputError, match=r"holds 3 colour images, but a\.mcap holds 2"):
        OakRecording(tmp_path / "a.mcap")


def test_colour_recording_is_no_depth(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "scene.mcap", frames(1, colour=True))

    with pytest.raises(InputError, match="image 0: the stream holds RGB888i images, expected RAW"):
        list(OakRecording(tmp_path / "scene.colour.mcap").frames())


def test_recording_of_other_messages_is_rejected(tmp_path: Path) -> None:
    load_depthai()
    import depthai as dai

    path = tmp_path / "imu.mcap"
    pipeline = dai.Pipeline(createImplicitDevice=False)
    node = pipeline.create(dai.node.RecordMessage)
    node.setRecordFile(path)
    pipeline.start()
    node.input.send(dai.IMUData())
    while node.input.getSize():
        time.sleep(0.001)
    pipeline.stop()
    pipeline.wait()

    with pytest.raises(InputError, match=r"IMUData, expected one stream of dai\.proto"):
        OakRecording(path)


def test_timeout_must_be_positive(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "scene.mcap", frames(1))

    for timeout_s in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match="time-out"):
            OakRecording(tmp_path / "scene.mcap", timeout_s=timeout_s)


def test_playback_slower_than_timeout_raises(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "scene.mcap", frames(1))

    with pytest.raises(InputError, match="stopped after 0 of 1 frames"):
        list(OakRecording(tmp_path / "scene.mcap", timeout_s=1e-12).frames())

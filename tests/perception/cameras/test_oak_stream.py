"""Tests of pairing depth and colour on the host."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.cameras import OakRecording
from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak_recorder import OakRecorder
from eyehand.perception.cameras.oak_stream import QUEUE_SIZE, images, next_pair, paired

from .oak_frames import image_messages, record_frames

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from eyehand.perception.frame import DepthFrame

    Frames = Callable[..., list[DepthFrame]]

load_depthai()
import depthai as dai  # noqa: E402 - depthai prints to stdout unless load_depthai came first


def test_later_colour_is_paired_with_its_depth(tmp_path: Path, frames: Frames) -> None:
    recorded = frames(12, colour=True)
    recorder = OakRecorder(tmp_path / "scene.mcap")
    for number, frame in enumerate(recorded):
        depth, _ = image_messages(frame, number / 30)
        _, colour = image_messages(frame, number / 30 + 0.016)
        recorder.write(depth, colour)
    recorder.finish()

    played = list(OakRecording(tmp_path / "scene.mcap").frames())

    assert len(played) == 12
    for before, after in zip(recorded, played, strict=True):
        assert before.colour is not None
        assert after.colour is not None
        assert np.array_equal(before.depth, after.depth)
        assert np.array_equal(before.colour, after.colour)


def test_slow_reader_of_live_stream_skips_old_frames(tmp_path: Path, frames: Frames) -> None:
    record_frames(tmp_path / "scene.mcap", frames(20))
    pipeline = dai.Pipeline(createImplicitDevice=False)
    replay = pipeline.create(dai.node.ReplayMessage)
    replay.setReplayFile(tmp_path / "scene.mcap")
    replay.setLoop(True)
    replay.setFps(200)
    queue = paired(pipeline, replay.out, None, 0.01, lossless=False)
    pipeline.start()
    try:
        numbers = []
        for _ in range(5):
            pair = next_pair(queue, 5.0)
            assert pair is not None
            numbers.append(images(pair)[0].getSequenceNum())
            time.sleep(0.1)
    finally:
        pipeline.stop()
        pipeline.wait()

    # At 200 Hz about 80 frames pass in the four pauses. The queue holds far fewer.
    assert numbers[-1] - numbers[0] > 4 * (QUEUE_SIZE + 1)


def test_missing_stream_is_awaited_until_timeout() -> None:
    queue = dai.MessageQueue("pairs", 4, True)

    started = time.monotonic()
    assert next_pair(queue, 0.35) is None
    assert 0.3 < time.monotonic() - started < 1.5
    assert next_pair(queue, -1.0) is None

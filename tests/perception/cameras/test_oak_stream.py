"""Tests of pairing depth and colour on the host."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
import pytest

from eyehand.perception.cameras.depthai_import import load_depthai
from eyehand.perception.cameras.oak_message import (
    QUEUE_SIZE,
    depth_frame,
    images,
    next_pair,
    paired,
)

from .oak_frames import image_messages

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.perception.frame import DepthFrame

    Frames = Callable[..., list[DepthFrame]]

load_depthai()
import depthai as dai  # noqa: E402 - depthai prints to stdout unless load_depthai came first


class Source(dai.node.ThreadedHostNode):
    """A node that sends image messages."""

    def __init__(self) -> None:
        super().__init__()
        self.out = self.createOutput()
        self.messages: list[dai.ImgFrame] = []
        self.pause = 0.0

    def run(self) -> None:
        """Send all messages."""
        for message in self.messages:
            if not self.isRunning():
                return
            self.out.send(message)
            time.sleep(self.pause)


@pytest.fixture
def pipeline():
    made = dai.Pipeline(createImplicitDevice=False)
    yield made
    made.stop()
    made.wait()


def test_later_colour_is_paired_with_its_depth(pipeline, frames: Frames) -> None:
    sent = frames(12, colour=True)
    depth, colour = pipeline.create(Source), pipeline.create(Source)
    depth.pause = colour.pause = 0.05
    depth.messages = [image_messages(frame, k / 30)[0] for k, frame in enumerate(sent)]
    later = [image_messages(frame, k / 30 + 0.016)[1] for k, frame in enumerate(sent)]
    colour.messages = [message for message in later if message is not None]
    queue = paired(pipeline, depth.out, colour.out, 0.0167)
    pipeline.start()
    pairs = 0
    while (pair := next_pair(queue, 1.0)) is not None:
        frame = depth_frame(*images(pair))
        assert frame is not None
        match = next(one for one in sent if np.array_equal(one.depth, frame.depth))
        assert match.colour is not None
        assert frame.colour is not None
        assert np.array_equal(match.colour, frame.colour)
        pairs += 1
    assert pairs >= 6


def test_slow_reader_skips_old_frames(pipeline, frames: Frames) -> None:
    source = pipeline.create(Source)
    source.pause = 0.005
    (frame,) = frames(1)
    for number in range(200):
        message = image_messages(frame, number / 200)[0]
        message.setSequenceNum(number)
        source.messages.append(message)
    queue = paired(pipeline, source.out, None, 0.01)
    pipeline.start()
    numbers = []
    for _ in range(5):
        pair = next_pair(queue, 5.0)
        assert pair is not None
        numbers.append(images(pair)[0].getSequenceNum())
        time.sleep(0.1)

    # At 200 Hz about 80 frames pass in the four pauses. The queue holds far fewer.
    assert numbers[-1] - numbers[0] > 4 * (QUEUE_SIZE + 1)


def test_missing_stream_is_awaited_until_timeout() -> None:
    queue = dai.MessageQueue("pairs", 4, True)

    started = time.monotonic()
    assert next_pair(queue, 0.35) is None
    assert 0.3 < time.monotonic() - started < 1.5
    assert next_pair(queue, -1.0) is None

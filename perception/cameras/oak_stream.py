"""Paired image messages from a depthai pipeline, with a time limit on every wait."""

from __future__ import annotations

import time
from datetime import timedelta
from typing import TYPE_CHECKING

from eyehand.errors import InputError

from .depthai_import import queue_closed_error

if TYPE_CHECKING:
    import depthai as dai

DEPTH, COLOUR = "depth", "colour"
"""Names of the two messages in a pair."""

QUEUE_SIZE = 2
"""Pairs in the queue: the one being read and the next one."""

POLL_S = 0.1
"""Duration of one wait inside depthai, s. Ctrl-C takes effect only between waits."""


def paired(
    pipeline: dai.Pipeline,
    depth: dai.Node.Output,
    colour: dai.Node.Output | None,
    tolerance_s: float,
) -> dai.MessageQueue:
    """Return a queue of message groups whose depth and colour were taken together.

    Old pairs are dropped, so that a slow reader gets the newest pair.

    Parameters
    ----------
    pipeline : depthai.Pipeline
        The pipeline to add the pairing to; not started yet.
    depth, colour : depthai.Node.Output
        The outputs to pair. Without colour the groups hold depth alone.
    tolerance_s : float
        Largest difference of the two time stamps, s.
    """
    import depthai as dai

    sync = pipeline.create(dai.node.Sync)
    sync.setRunOnHost(True)
    sync.setSyncThreshold(timedelta(seconds=tolerance_s))
    for name, output in ((DEPTH, depth), (COLOUR, colour)):
        if output is not None:
            output.link(sync.inputs[name])
            sync.inputs[name].setBlocking(False)
    return sync.out.createOutputQueue(maxSize=QUEUE_SIZE, blocking=False)


def next_pair(queue: dai.MessageQueue, timeout_s: float) -> dai.MessageGroup | None:
    """Wait for the next pair; None when none comes within the time or the stream has ended."""
    import depthai as dai

    closed = queue_closed_error()
    deadline = time.monotonic() + timeout_s
    while (left := deadline - time.monotonic()) > 0:
        try:
            message = queue.get(timedelta(seconds=min(left, POLL_S)))
        except closed:
            return None
        if isinstance(message, dai.MessageGroup):
            return message
    return None


def images(pair: dai.MessageGroup) -> tuple[dai.ImgFrame, dai.ImgFrame | None]:
    """Return the depth image of a pair, and its colour image or None.

    Raises
    ------
    InputError
        If one of them is some other message.
    """
    colour = _image(pair, COLOUR) if COLOUR in pair.getMessageNames() else None
    return _image(pair, DEPTH), colour


def _image(pair: dai.MessageGroup, name: str) -> dai.ImgFrame:
    import depthai as dai

    message = pair[name]
    if not isinstance(message, dai.ImgFrame):
        raise InputError(
            f"the {name} stream holds {type(message).__name__} messages, expected images"
        )
    return message

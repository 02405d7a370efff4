"""Write OAK recordings: MCAP files of depthai image messages."""

from __future__ import annotations

import os
import secrets
import time
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from eyehand.errors import DeviceError, InputError

from .depthai_import import load_depthai, queue_closed_error
from .mcap_file import seal

if TYPE_CHECKING:
    import depthai as dai

SUFFIX = ".mcap"
"""Suffix of recordings."""

WRITE_TIMEOUT_S = 5.0
"""Maximum time to write one frame, s."""

POLL_S = 0.002
"""Pause between two checks of the frames that wait to be written, s."""


def colour_path(path: Path) -> Path:
    """Return the path of the colour recording that belongs to a depth recording."""
    return path.with_suffix(f".colour{path.suffix}")


class OakRecorder:
    """A writer of recordings. It takes messages one by one, and the file appears with `finish`.

    Parameters
    ----------
    path : Path or str
        The depth recording, `*.mcap`.

    Raises
    ------
    InputError
        If the name does not end in .mcap or the folder is missing or not writable.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        """The depth recording."""
        self.frames = 0
        """Frames written so far."""
        if self.path.suffix.lower() != SUFFIX:
            raise InputError(f"cannot record to {self.path}: the name must end in {SUFFIX}")
        folder = self.path.parent
        if not folder.is_dir():
            raise InputError(f"cannot record to {self.path}: there is no folder {folder}")
        if self.path.is_dir() or not os.access(folder, os.W_OK):
            raise InputError(f"cannot record to {self.path}: not allowed to write there")
        self._files: dict[Path, Path] = {}
        self._nodes: list[dai.node.RecordMessage] = []
        self._pipeline: dai.Pipeline | None = None

    def write(self, depth: dai.ImgFrame, colour: dai.ImgFrame | None = None) -> None:
        """Add a frame. Its messages are renumbered, because playback pairs them by number.

        Raises
        ------
        InputError
            If the frame has colour and earlier ones have none, or the other way round.
        DeviceError
            If the disk does not take the data.
        """
        messages = [depth] if colour is None else [depth, colour]
        if self._pipeline is None:
            self._start(len(messages))
        if len(messages) != len(self._nodes):
            has, had = ("a", "none") if colour is not None else ("no", "one")
            raise InputError(
                f"cannot record frame {self.frames}: it has {has} colour image, the frames before "
                f"have {had}"
            )
        for node, message in zip(self._nodes, messages, strict=True):
            message.setSequenceNum(self.frames)
            self._send(node, message)
        self.frames += 1

    def finish(self) -> None:
        """Wait until all frames are on the disk, verify the files, and rename them.

        Without frames, nothing happens.

        Raises
        ------
        DeviceError
            If frames are missing from the files: the disk is full, or too slow.
        """
        if self._pipeline is None:
            return
        self._drain()
        self._stop()
        for temporary, final in self._files.items():
            try:
                written = seal(temporary).messages
            except InputError as error:
                raise self._disk_error(f"{error}") from error
            if written != self.frames:
                raise self._disk_error(f"{written} of {self.frames} frames arrived in {final.name}")
        try:
            # Colour first, so that a depth recording is never beside the colour of another one.
            if len(self._files) == 1:
                colour_path(self.path).unlink(missing_ok=True)
            for temporary, final in reversed(self._files.items()):
                temporary.replace(final)
        except OSError as error:
            raise self._disk_error(error.strerror or str(error)) from error
        self._files = {}

    def discard(self) -> None:
        """Stop, and remove unfinished files. After `finish` there are none."""
        self._stop()
        for temporary in self._files:
            temporary.unlink(missing_ok=True)
        self._files = {}

    def _start(self, streams: int) -> None:
        load_depthai()
        import depthai as dai

        finals = [self.path, colour_path(self.path)][:streams]
        self._files = {
            final.with_name(f".{secrets.token_hex(8)}{SUFFIX}"): final for final in finals
        }
        self._pipeline = dai.Pipeline(createImplicitDevice=False)
        for temporary in self._files:
            node = self._pipeline.create(dai.node.RecordMessage)
            node.setRecordFile(temporary)
            # The default level of depthai takes 30 times as long, for files a quarter smaller.
            node.setCompressionLevel(dai.RecordConfig.CompressionLevel.FAST)
            # A failing node prints to stdout. `finish` detects the failure.
            node.setLogLevel(dai.LogLevel.OFF)
            self._nodes.append(node)
        self._pipeline.start()

    def _send(self, node: dai.node.RecordMessage, message: dai.ImgFrame) -> None:
        closed = queue_closed_error()
        try:
            sent = node.input.send(message, timedelta(seconds=WRITE_TIMEOUT_S))
        except closed:
            sent = False
        if not sent:
            raise self._disk_error(f"frame {self.frames} was not taken")

    def _drain(self) -> None:
        # A stopped pipeline discards the messages in its queues.
        deadline = time.monotonic() + WRITE_TIMEOUT_S
        before = self._waiting()
        while (waiting := self._waiting()) and time.monotonic() < deadline:
            if waiting < before:
                deadline = time.monotonic() + WRITE_TIMEOUT_S
                before = waiting
            time.sleep(POLL_S)

    def _waiting(self) -> int:
        """Return the number of messages that the writer threads have not fetched yet."""
        return sum(node.input.getSize() for node in self._nodes)

    def _stop(self) -> None:
        if self._pipeline is not None:
            self._pipeline.stop()
            self._pipeline.wait()
        self._pipeline = None
        self._nodes = []

    def _disk_error(self, what: str) -> DeviceError:
        return DeviceError(f"cannot record {self.path}: {what}; is the disk full or too slow?")

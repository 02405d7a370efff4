"""Playback of OAK recordings, without a device."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from eyehand.errors import InputError

from .depthai_import import load_depthai
from .mcap_file import check_mcap
from .oak_message import depth_frame
from .oak_recorder import colour_path
from .oak_stream import images, next_message, next_pair, paired

if TYPE_CHECKING:
    from collections.abc import Generator

    import depthai as dai

    from ..frame import DepthFrame

IMAGE_SCHEMA = "dai.proto.img_frame.ImgFrame"
"""Name of the message type that depthai writes for images."""

DEFAULT_TIMEOUT_S = 10.0
"""Maximum time to read and unpack one frame, s. Usually it takes milliseconds."""

UNPACED_FPS = 1e6
"""Replay speed that leaves no pause between frames: depthai rounds the pause to whole ms."""

ANY_TIME_S = 3600.0
"""Allowed time difference within a pair, s. It keeps every recorded pair together."""


class OakRecording:
    """A recording made by `OakCamera` or by depthai's RecordMessage node.

    Frames come as fast as they are read, in the order in which they were taken. Opening a recording
    checks it for damage. Recordings of `OakCamera` carry a checksum. Others are
    played once, which takes some milliseconds per frame and finds missing images but not changed
    pixels.

    Parameters
    ----------
    path : Path or str
        MCAP file of RAW16 depth images in mm.
    colour : bool
        Whether to play `<stem>.colour.mcap` too, where it exists.
    timeout_s : float
        Maximum time to read one frame, s.

    Raises
    ------
    InputError
        If the file is missing, not MCAP, truncated, damaged, or holds something else than depthai
        images; if the colour file is so, or has another number of frames.
    """

    def __init__(
        self, path: Path | str, *, colour: bool = True, timeout_s: float = DEFAULT_TIMEOUT_S
    ) -> None:
        if not timeout_s > 0:
            raise InputError(f"the time-out must be > 0 s, got {timeout_s}")
        self.path = Path(path)
        """The depth recording."""
        self.timeout_s = timeout_s
        """Maximum time to read one frame, s."""
        self._paths = [self.path]
        self._length = _checked_length(self.path, timeout_s)
        beside = colour_path(self.path)
        if colour and beside.is_file():
            images_beside = _checked_length(beside, timeout_s)
            if images_beside != self._length:
                raise InputError(
                    f"{beside}: holds {images_beside} colour images, but {self.path.name} holds "
                    f"{self._length} depth images: they are not of one recording"
                )
            self._paths.append(beside)

    def __len__(self) -> int:
        """Return the number of depth images in the recording."""
        return self._length

    def frames(self) -> Generator[DepthFrame, None, None]:
        """Yield the frames from the first to the last. Images without any reading are skipped.

        Depth is the recorded whole millimetres in m, intrinsics are those that the messages
        carry (float32), `T_world_camera` is what was recorded with them or None.

        Raises
        ------
        InputError
            If an image is not usable as depth, or the file is damaged or slower than the time-out.
        """
        load_depthai()
        import depthai as dai

        pipeline = dai.Pipeline(createImplicitDevice=False)
        # At its end a replay stops the pipeline and drops the frames that a slow reader has not
        # fetched (13 of 30 frames measured). Therefore it loops, and the reader counts frames.
        outputs = [_replay(pipeline, path, loop=True) for path in self._paths]
        colour = outputs[1] if len(outputs) > 1 else None
        queue = paired(pipeline, outputs[0], colour, ANY_TIME_S, lossless=True)
        pipeline.start()
        try:
            for number in range(self._length):
                pair = next_pair(queue, self.timeout_s)
                if pair is None:
                    raise InputError(
                        f"{self.path}: playback stopped after {number} of {self._length} frames; "
                        f"the file is damaged, or a frame takes more than {self.timeout_s:g} s"
                    )
                try:
                    frame = depth_frame(*images(pair))
                except InputError as error:
                    raise InputError(f"{self.path}: image {number}: {error}") from error
                if frame is not None:
                    yield frame
        finally:
            pipeline.stop()
            pipeline.wait()


def _replay(pipeline: dai.Pipeline, path: Path, *, loop: bool) -> dai.Node.Output:
    import depthai as dai

    replay = pipeline.create(dai.node.ReplayMessage)
    replay.setReplayFile(path.absolute())
    replay.setFps(UNPACED_FPS)
    replay.setLoop(loop)
    # A failing node prints to stdout. Playback detects the missing frames.
    replay.setLogLevel(dai.LogLevel.OFF)
    return replay.out


def _checked_length(path: Path, timeout_s: float) -> int:
    """Return the number of images in a recording, after a check that all can be unpacked."""
    contents = check_mcap(path)
    if contents.messages == 0:
        raise InputError(f"{path}: holds no frames")
    if contents.schemas != (IMAGE_SCHEMA,):
        schemas = ", ".join(contents.schemas) or "unnamed messages"
        raise InputError(f"{path}: holds {schemas}, expected one stream of {IMAGE_SCHEMA}")
    if not contents.sealed:
        unpacked = _count_by_playing(path, timeout_s)
        if unpacked != contents.messages:
            raise InputError(
                f"{path}: damaged, {unpacked} of {contents.messages} images can be unpacked"
            )
    return contents.messages


def _count_by_playing(path: Path, timeout_s: float) -> int:
    load_depthai()
    import depthai as dai

    pipeline = dai.Pipeline(createImplicitDevice=False)
    queue = _replay(pipeline, path, loop=False).createOutputQueue(maxSize=1, blocking=False)
    count = 0

    def note(_: dai.ADatatype) -> None:
        nonlocal count
        count += 1

    # Messages are counted as they arrive: those left in the queue at the end are lost.
    callback = queue.addCallback(note)
    try:
        pipeline.start()
        while next_message(queue, timeout_s) is not None:
            pass
        pipeline.stop()
        pipeline.wait()
    finally:
        # A thread of depthai may destroy the queue. Freeing a Python function there crashes.
        queue.removeCallback(callback)
    return count

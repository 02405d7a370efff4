"""Depth frames of a command: one file, a recording, or a live camera."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from eyehand.errors import InputError
from eyehand.perception import DepthFrame
from eyehand.perception.io import FRAME_SUFFIXES, read_frame

RECORDING_SUFFIX = ".mcap"


def check_source(
    frame: Path | None, oak: bool, record: Path | None, count: int | None, topic: str = ""
) -> None:
    """Check the options that choose the frames.

    Raises
    ------
    InputError
        If two options exclude each other, one lacks another, or the count is below 1.
    """
    if (frame is None) == (not oak):
        raise InputError("give either a frame file or --oak")
    if record is not None and not oak:
        raise InputError("--record needs --oak")
    if topic and not is_recording(frame):
        raise InputError(f"--topic needs a recording ({RECORDING_SUFFIX}), got {frame or '--oak'}")
    if count is not None and count < 1:
        raise InputError(f"--frames must be >= 1, got {count}")


def open_frames(
    path: Path | None,
    camera: Path | None,
    oak: bool,
    record: Path | None,
    count: int | None,
    topic: str = "",
) -> Iterator[tuple[str | None, str, DepthFrame]]:
    """Yield (folder name or None, source, frame). The name is None if there is one frame.

    Parameters
    ----------
    path
        Frame file or recording; None with `oak`.
    camera
        Camera file of a frame; None searches beside it.
    oak
        Whether to read from a connected Luxonis OAK camera.
    record
        File to record the camera to.
    count
        Number of frames; None for 1 of a camera and all of a recording.
    topic
        Topic of the depth images in a recording of ROS 2; empty selects the only one.

    Raises
    ------
    InputError
        If the file cannot be read or holds no depth frame.
    """
    if oak:
        from eyehand.perception.cameras import OakCamera

        stream, source, count = OakCamera(record=record), "OAK camera", count or 1
    elif is_recording(path):
        from eyehand.perception.cameras import RosRecording

        assert path is not None
        stream, source = RosRecording(path, topic=topic, camera=camera), str(path)
    else:
        assert path is not None
        if path.suffix.lower() not in FRAME_SUFFIXES:
            raise InputError(
                f"{path}: suffix {path.suffix!r} is not a frame format, expected one of "
                f"{', '.join((*FRAME_SUFFIXES, RECORDING_SUFFIX))} (.npz with `depth` and `K`)"
            )
        if count not in (None, 1):
            raise InputError(f"--frames needs --oak or a recording, and {path} is one frame")
        yield None, str(path), read_frame(path, camera)
        return
    # islice does not request a frame beyond the last one, so that a live camera does not wait.
    for number, frame in enumerate(islice(stream.frames(), count)):
        yield f"{number:04d}", f"{source}, frame {number}", frame


def is_recording(path: Path | None) -> bool:
    """Report whether a file is a recording."""
    return path is not None and path.suffix.lower() == RECORDING_SUFFIX

"""Depth frames of a command: one file, a recording, or a live camera."""

# cyclopts reads the annotations at run time, so their names must exist then.

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from eyehand.errors import InputError
from eyehand.perception import DepthFrame, frame_faults
from eyehand.perception.io import FRAME_SUFFIXES, read_frame

from .frame_masks import FrameMasks
from .perceived_frame import check_usable

RECORDING_SUFFIX = ".mcap"


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class FrameStream:
    """The options of the commands that read a frame, a recording or a camera."""

    camera: Path | None = None
    """Camera file with the intrinsics; default: <frame>.json or camera.json beside the frame, or
    the CameraInfo of a recording."""
    masks: Annotated[FrameMasks | None, Parameter(name="*", group="Masks")] = None
    """Readings of the robot, and outside a region, that are no objects."""
    oak: bool = False
    """Read from a connected Luxonis OAK camera instead of a file."""
    record: Path | None = None
    """With --oak: also record what the camera sees to this .mcap file, with messages of ROS 2."""
    frames: Annotated[int | None, Parameter(name="--frames")] = None
    """Frames to take from a camera or a recording; default 1 from a camera, all of a recording."""
    topic: str = ""
    """Topic of the depth images in a recording of ROS 2; default: the only one."""

    def check(self, path: Path | None) -> None:
        """Check that the options choose frames together with a file.

        Raises
        ------
        InputError
            If two options exclude each other, one lacks another, or the count is below 1.
        """
        if (path is None) == (not self.oak):
            raise InputError("give either a frame file or --oak")
        if self.record is not None and not self.oak:
            raise InputError("--record needs --oak")
        if self.topic and not is_recording(path):
            raise InputError(
                f"--topic needs a recording ({RECORDING_SUFFIX}), got {path or '--oak'}"
            )
        if self.frames is not None and self.frames < 1:
            raise InputError(f"--frames must be >= 1, got {self.frames}")

    def has_several(self, path: Path | None) -> bool:
        """Report whether more than one frame may come."""
        return (self.oak or is_recording(path)) and (self.frames or 2 - self.oak) > 1

    def open(
        self, path: Path | None, prepare: Callable[[], object]
    ) -> Iterator[tuple[str | None, str, DepthFrame]]:
        """Yield (folder name or None, source, masked frame). The name is None for a frame file.

        Parameters
        ----------
        path
            Frame file or recording; None for a connected camera.
        prepare
            Called once, after the first frame has been masked and before it is yielded: it loads
            kernels, which takes longer than to refuse a file. The times of the first frame then
            hold no loading.

        Raises
        ------
        InputError
            If the file cannot be read, holds no depth frame, or a frame file cannot be used.
        """
        first = True
        for name, source, frame in self._read(path):
            if name is None:
                check_usable(frame_faults(frame), source)
            masked = frame if self.masks is None else self.masks.applied(frame)
            if first:
                prepare()
            first = False
            yield name, source, masked
        if first:
            raise InputError(f"{path} holds no frame")

    def _read(self, path: Path | None) -> Iterator[tuple[str | None, str, DepthFrame]]:
        if path is None:
            from eyehand.perception.cameras import OakCamera

            stream, source, count = OakCamera(record=self.record), "OAK camera", self.frames or 1
        elif is_recording(path):
            from eyehand.perception.cameras import RosRecording

            stream = RosRecording(path, topic=self.topic, camera=self.camera)
            source, count = str(path), self.frames
        else:
            if path.suffix.lower() not in FRAME_SUFFIXES:
                raise InputError(
                    f"{path}: suffix {path.suffix!r} is not a frame format, expected one of "
                    f"{', '.join((*FRAME_SUFFIXES, RECORDING_SUFFIX))} (.npz with `depth` and `K`)"
                )
            if self.frames not in (None, 1):
                raise InputError(f"--frames needs --oak or a recording, and {path} is one frame")
            yield None, str(path), read_frame(path, self.camera)
            return
        # islice does not request a frame beyond the last one, so that a live camera does not wait.
        for number, frame in enumerate(islice(stream.frames(), count)):
            yield f"{number:04d}", f"{source}, frame {number}", frame


def is_recording(path: Path | None) -> bool:
    """Report whether a path is a recording: a file, or a folder that may hold one."""
    return path is not None and (path.suffix.lower() == RECORDING_SUFFIX or path.is_dir())

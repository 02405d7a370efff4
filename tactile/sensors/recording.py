"""Recordings of tactile sensors in MCAP: write one from any sensor, and play it as a sensor."""

from __future__ import annotations

import secrets
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from eyehand.errors import DeviceError, InputError

from ..calibration import Calibration
from ..calibration_file import calibration_bytes, read_calibration
from .messages import (
    FRAME_SCHEMA,
    FRAME_TYPE,
    INFO_SCHEMA,
    INFO_TYPE,
    decode_frame,
    decode_info,
    encode_frame,
    encode_info,
)
from .protocol import SensorInfo, TactileFrame

INFO_TOPIC, FRAME_TOPIC = "/tactile/info", "/tactile/frames"
"""Topics of the description and of the images."""
CALIBRATION = "calibration.npz"
"""Name of the attachment with the calibration, as `save_calibration` writes it."""
SUFFIX = ".mcap"
MAX_RECORD_BYTES = 1 << 28
"""Maximum size of a record of a file that is played, bytes."""


class TactileRecorder:
    """Write a recording. Use it as a context; the file appears when the context ends.

    The file is MCAP with ROS 2 messages (`messages.INFO_SCHEMA` and `FRAME_SCHEMA`), which ROS 2
    tools and Foxglove read. It needs the extra `ros`.

    Parameters
    ----------
    path
        File to write, ending in .mcap.
    info
        Description of the sensor.
    calibration
        Calibration of the sensor, which is attached to the file.

    Raises
    ------
    InputError
        If the name does not end in .mcap, or the folder does not exist.
    """

    def __init__(
        self, path: Path | str, info: SensorInfo, calibration: Calibration | None = None
    ) -> None:
        from mcap.writer import Writer

        self._path, self._info = Path(path), info
        if self._path.suffix != SUFFIX:
            raise InputError(f"a recording must be a {SUFFIX} file, got {path}")
        if not self._path.parent.is_dir():
            raise InputError(f"cannot write {path}: folder {self._path.parent} does not exist")
        self._temporary = self._path.parent / f".{secrets.token_hex(8)}{SUFFIX}"
        self._failed = False
        try:
            self._file = self._temporary.open("wb")
        except OSError as error:
            raise InputError(f"cannot write {path}: {error.strerror}") from error
        self._writer = Writer(self._file)
        self._writer.start(profile="ros2", library="eyehand")
        channels = [
            self._writer.register_channel(
                topic, "cdr", self._writer.register_schema(name, "ros2msg", schema.encode())
            )
            for topic, name, schema in (
                (INFO_TOPIC, INFO_TYPE, INFO_SCHEMA),
                (FRAME_TOPIC, FRAME_TYPE, FRAME_SCHEMA),
            )
        ]
        self._channel = channels[1]
        self._writer.add_message(channels[0], 0, encode_info(info), 0)
        if calibration is not None:
            data = calibration_bytes(calibration)
            self._writer.add_attachment(0, 0, CALIBRATION, "application/zip", data)
        self.frames = 0
        """Number of images so far."""

    def write(self, frame: TactileFrame) -> None:
        """Append an image.

        Raises
        ------
        InputError
            If the image does not belong to the sensor, or its time is negative.
        DeviceError
            If the system fails to write.
        """
        frame.check(self._info)
        stamp = round(1e9 * frame.time)
        if stamp < 0:
            raise InputError(f"the time of an image must be >= 0 s, got {frame.time}")
        try:
            self._writer.add_message(self._channel, stamp, encode_frame(frame), stamp, self.frames)
        except OSError as error:
            self._failed = True
            raise DeviceError(f"cannot write {self._path}: {error.strerror}") from error
        self.frames += 1

    def __enter__(self) -> TactileRecorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Finish the file. It is kept after an error of the sensor, but not if writing failed."""
        try:
            self._writer.finish()
            self._file.close()
            if not self._failed:
                self._temporary.replace(self._path)
        except OSError as fault:
            raise DeviceError(f"cannot write {self._path}: {fault.strerror}") from fault
        finally:
            self._file.close()
            self._temporary.unlink(missing_ok=True)


class RecordedSensor:
    """A recording as a sensor.

    Parameters
    ----------
    path
        File that `TactileRecorder` wrote, or another MCAP file with the same messages.
    speed
        Times real time; 0 returns images without waiting.

    Raises
    ------
    InputError
        If the file does not exist, is damaged, or has no tactile messages or images.
    """

    def __init__(self, path: Path | str, speed: float = 0.0) -> None:
        from mcap.reader import SeekingReader

        self._path, self._speed = Path(path), speed
        if not 0 <= speed < float("inf"):
            raise InputError(f"speed must be finite and >= 0, got {speed}")
        try:
            self._file = self._path.open("rb")
        except OSError as error:
            raise InputError(f"cannot read recording {path}: {error.strerror}") from error
        self._reader = self._guarded(
            lambda: SeekingReader(
                self._file, validate_crcs=True, record_size_limit=MAX_RECORD_BYTES
            )
        )
        self._messages = iter(())
        info = self._next_of(INFO_TOPIC)
        if info is None:
            self.close()
            raise InputError(f"{path} has no topic {INFO_TOPIC}: it is no tactile recording")
        if self._next_of(FRAME_TOPIC) is None:
            self.close()
            raise InputError(f"{path} has no images on {FRAME_TOPIC}: there is nothing to play")
        self._info = self._guarded(lambda: decode_info(info))
        self._rewind()

    @property
    def info(self) -> SensorInfo:
        """Description of the sensor."""
        return self._info

    @property
    def calibration(self) -> Calibration | None:
        """The attached calibration; None if the recording has none."""
        found = self._guarded(
            lambda: [item for item in self._reader.iter_attachments() if item.name == CALIBRATION]
        )
        return read_calibration(found[0].data, str(self._path)) if found else None

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Return the next image, or None at the end. It waits for the image's time."""
        frame = self._held
        if frame is None:
            data = self._guarded(lambda: next(self._messages, None))
            if data is None:
                return None
            frame = self._held = self._guarded(lambda: self._decoded(data[2].data))
        if self._speed > 0.0:
            start = self._start
            if start is None:
                start = self._start = time.monotonic() - frame.time / self._speed
            left = start + frame.time / self._speed - time.monotonic()
            time.sleep(max(min(left, timeout), 0.0))
            if left > timeout:
                return None
        self._held = None
        return frame

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _decoded(self, data: bytes) -> TactileFrame:
        frame = decode_frame(data)
        frame.check(self._info)
        return frame

    def _rewind(self) -> None:
        self._messages = iter(self._reader.iter_messages(topics=[FRAME_TOPIC]))
        self._held: TactileFrame | None = None
        self._start: float | None = None

    def _next_of(self, topic: str) -> bytes | None:
        """Return the first message of a topic."""
        messages = self._guarded(lambda: iter(self._reader.iter_messages(topics=[topic])))
        first = self._guarded(lambda: next(messages, None))
        return None if first is None else first[2].data

    def _guarded(self, action: Any) -> Any:
        """Run an action; damage of the file becomes an `InputError` with the file's name.

        The decoders of chunks check little themselves, so damage raises exceptions of many types.
        """
        try:
            return action()
        except Exception as error:
            self._file.close()
            fault = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"{self._path} is not a tactile recording: {fault}") from error


def record(sensor: Any, path: Path | str, seconds: float, calibration: Any = None) -> int:
    """Record a sensor for a time by its own clock, and return the number of images.

    Parameters
    ----------
    sensor
        A `TactileSensor`.
    path
        File to write, ending in .mcap.
    seconds
        Duration, s, > 0.
    calibration
        Calibration to attach, or None.

    Raises
    ------
    InputError
        If the duration is not positive, the file cannot be written, or the sensor's clock runs too
        fast for its rate, as in ms.
    """
    if not seconds > 0:
        raise InputError(f"seconds must be > 0, got {seconds}")
    with TactileRecorder(path, sensor.info, calibration) as recorder:
        first = frame = sensor.read()
        while frame is not None and first is not None and frame.time - first.time < seconds:
            recorder.write(frame)
            frame = sensor.read()
        if frame is not None and first is not None:
            sensor.info.check_clock(recorder.frames, frame.time - first.time)
        return recorder.frames

"""Tactile arrays on a serial line, with or without shear.

Each image is one frame of bytes. Numbers are little-endian:

| bytes | content |
| --- | --- |
| 0, 1 | `A5 5A` |
| 2, 3 | rows and columns |
| 4 | values per tactel: 1 (pressure) or 3 (pressure, shear along x, shear along y) |
| 5 | sequence number, 0..255, then 0 again |
| 6..9 | time of the image, uint32, µs, then 0 again |
| 10.. | the values, tactel by tactel, row by row: pressures uint16, shear int16 |
| last 2 | CRC-16/CCITT-FALSE of all bytes before (polynomial 1021, start FFFF) |
"""

from __future__ import annotations

import binascii
import os
import select
import struct
import termios
import time
import tty
from pathlib import Path

import numpy as np

from eyehand.errors import DeviceError, InputError

from ..image import TactileArray
from .protocol import SensorInfo, TactileFrame

SYNC = b"\xa5\x5a"
HEADER = struct.Struct("<2sBBBBI")
CRC = struct.Struct("<H")
CLOCK_SPAN = 2**32
"""Microseconds after which the sensor's clock starts again."""
SHEAR_PER_COUNT = 1.0
"""Default scale of shear, Pa per count."""
MAX_SIDE = 255
"""Maximum number of rows and columns: each is one byte of a frame."""


class SerialSensor:
    """A tactile array on a serial line.

    Damaged frames are skipped. If several frames have arrived, the newest one counts, so that a
    slow reader does not lag behind.

    Parameters
    ----------
    port
        Device, for example /dev/ttyUSB0.
    info
        Description of the sensor. Its array must be an even grid.
    baud
        Bits per second. A frame of 16 x 16 tactels has 524 bytes: 2,000,000 baud carry 380 images
        per second.
    shear_scale
        Pa per count of shear.

    Raises
    ------
    InputError
        If the array is not a grid of at most 255 rows and columns, or the system does not know
        the baud rate.
    DeviceError
        If the port cannot be opened.
    """

    def __init__(
        self,
        port: Path | str,
        info: SensorInfo,
        baud: int = 2_000_000,
        shear_scale: float = SHEAR_PER_COUNT,
    ) -> None:
        if info.array.grid is None:
            raise InputError(f"{info.name}: a serial sensor needs a grid of tactels")
        if max(info.array.grid) > MAX_SIDE:
            raise InputError(
                f"{info.name}: a serial frame has at most {MAX_SIDE} rows and columns, got "
                f"{info.array.grid}"
            )
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise InputError(f"this system has no serial line with {baud} baud")
        self._info, self._port, self._scale = info, str(port), shear_scale
        self._layout = (*info.array.grid, 3 if info.shear else 1)
        self._length = HEADER.size + 2 * int(np.prod(self._layout)) + CRC.size
        self._buffer = bytearray()
        self._clock, self._start = 0, 0
        self.damaged = 0
        """Number of damaged frames so far."""
        try:
            self._line = os.open(self._port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise DeviceError(f"cannot open {port}: {error.strerror}") from error
        try:
            tty.setraw(self._line)
            settings = termios.tcgetattr(self._line)
            settings[4] = settings[5] = speed
            termios.tcsetattr(self._line, termios.TCSANOW, settings)
            termios.tcflush(self._line, termios.TCIFLUSH)
        except termios.error as error:
            os.close(self._line)
            raise DeviceError(f"{port} is not a serial line: {error.args[-1]}") from error

    @property
    def info(self) -> SensorInfo:
        """Description of the sensor."""
        return self._info

    def read(self, timeout: float = 1.0) -> TactileFrame | None:
        """Wait for the next image; None if none comes within the timeout, s.

        Raises
        ------
        DeviceError
            If the line was closed.
        InputError
            If the sensor has another number of tactels.
        """
        end = time.monotonic() + timeout
        while True:
            ready, _, _ = select.select([self._line], [], [], max(end - time.monotonic(), 0.0))
            if ready:
                self._receive()
            frame = self._newest()
            if frame is not None or time.monotonic() >= end:
                return frame

    def close(self) -> None:
        """Close the line."""
        os.close(self._line)

    def _receive(self) -> None:
        try:
            data = os.read(self._line, 2**16)
        except BlockingIOError:
            return
        except OSError as error:
            raise DeviceError(f"{self._port} was disconnected: {error.strerror}") from error
        if not data:
            raise DeviceError(f"{self._port} was disconnected")
        self._buffer += data

    def _newest(self) -> TactileFrame | None:
        """Take all complete frames out of the buffer, and decode the last one."""
        newest = None
        while True:
            start = self._buffer.find(SYNC)
            if start < 0:
                # The last byte may be the first one of a sync.
                del self._buffer[:-1]
                break
            del self._buffer[:start]
            if len(self._buffer) < HEADER.size:
                break
            _, rows, columns, channels, _, clock = HEADER.unpack_from(self._buffer)
            self._check_layout((rows, columns, channels))
            if len(self._buffer) < self._length:
                break
            frame = bytes(self._buffer[: self._length])
            if (rows, columns, channels) == self._layout and _is_undamaged(frame):
                self._start += self._skipped(clock)
                self._clock, newest = clock, frame
                del self._buffer[: self._length]
            else:
                self.damaged += 1
                del self._buffer[: len(SYNC)]
        return None if newest is None else self._decoded(newest)

    def _skipped(self, clock: int) -> int:
        """Return by how much the start of the clock moves, µs, so that times never decrease.

        A clock that starts again far below its span was reset: the next image is a period later.
        """
        fallen = self._clock - clock
        if fallen <= 0:
            return 0
        return CLOCK_SPAN if fallen > CLOCK_SPAN // 2 else fallen + round(1e6 / self._info.rate)

    def _check_layout(self, layout: tuple[int, int, int]) -> None:
        """Raise an `InputError` if an undamaged frame has another layout."""
        length = HEADER.size + 2 * int(np.prod(layout)) + CRC.size
        if layout == self._layout or len(self._buffer) < length:
            return
        if _is_undamaged(bytes(self._buffer[:length])):
            raise InputError(
                f"{self._port} sends {layout[0]} x {layout[1]} tactels with {layout[2]} values, "
                f"{self._info.name} needs {self._layout[0]} x {self._layout[1]} with "
                f"{self._layout[2]}"
            )

    def _decoded(self, frame: bytes) -> TactileFrame:
        values = np.frombuffer(frame[HEADER.size : -CRC.size], "<u2")
        raw, shear = values.astype(np.uint16), None
        if self._layout[2] == 3:
            columns = values.reshape(-1, 3)
            raw = columns[:, 0].astype(np.uint16)
            shear = self._scale * columns[:, 1:].astype(np.int16).astype(np.float64)
        return TactileFrame(1e-6 * (self._start + self._clock), raw, shear)


def serial_16x16(port: Path | str, rate: float = 300.0, bits: int = 12) -> SerialSensor:
    """Open a 16 x 16 array with a pitch of 5 mm on a serial line.

    Raises
    ------
    DeviceError
        If the port cannot be opened.
    """
    return SerialSensor(port, SensorInfo("serial 16x16", TactileArray.flat(), rate, bits))


def serial_4x6_shear(
    port: Path | str, rate: float = 100.0, shear_scale: float = SHEAR_PER_COUNT
) -> SerialSensor:
    """Open a 4 x 6 array with shear, 16 bits and a pitch of 4.7 mm on a serial line.

    Raises
    ------
    DeviceError
        If the port cannot be opened.
    """
    info = SensorInfo("serial 4x6 shear", TactileArray.flat(4, 6, 0.0047), rate, 16, shear=True)
    return SerialSensor(port, info, shear_scale=shear_scale)


def _is_undamaged(frame: bytes) -> bool:
    """Return whether the last two bytes of a frame are the CRC of the others."""
    return crc16(frame[: -CRC.size]) == CRC.unpack(frame[-CRC.size :])[0]


def crc16(data: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE of some bytes."""
    return binascii.crc_hqx(data, 0xFFFF)

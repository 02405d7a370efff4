"""The two ROS 2 messages of a tactile recording, encoded as CDR."""

from __future__ import annotations

import struct

import numpy as np

from eyehand.errors import InputError

from ..image import TactileArray
from .protocol import SensorInfo, TactileFrame

INFO_TYPE, FRAME_TYPE = "eyehand_msgs/msg/TactileInfo", "eyehand_msgs/msg/TactileFrame"
"""Names of the messages."""
INFO_SCHEMA = """\
# A tactile sensor: sent once, before its images. Lengths are in metres.
string name
float64 rate          # nominal images per second
uint32 bits           # of the converter
uint32 shear          # 1 if images have shear, else 0
uint32 rows           # of an even grid (along y), 0 for other arrays
uint32 columns        # of an even grid (along x), 0 for other arrays
float64[] positions   # x, y, z of each tactel in the sensor's frame
float64[] normals     # x, y, z of each tactel, unit vectors out of the sensor
float64[] areas       # of each tactel, square metres
uint32[] neighbours   # pairs of adjacent tactels, counted from 0
"""
FRAME_SCHEMA = """\
# One image of a tactile sensor, before calibration.
float64 time          # by the sensor's clock, seconds
uint16[] raw          # reading of each tactel
float32[] shear       # x, y of each tactel, pascal; empty without shear
"""
_HEADER = b"\x00\x01\x00\x00"
"""CDR header: plain, little-endian."""


class _Writer:
    """Write CDR: each value is aligned to its size, counted from the end of the header."""

    def __init__(self) -> None:
        self._parts = bytearray()

    def number(self, code: str, value: float) -> None:
        packed = struct.pack(f"<{code}", value)
        self._align(len(packed))
        self._parts += packed

    def text(self, value: str) -> None:
        data = value.encode() + b"\x00"
        self.number("I", len(data))
        self._parts += data

    def array(self, dtype: str, values: object) -> None:
        data = np.ascontiguousarray(values, dtype).ravel()
        self.number("I", data.size)
        if data.size:
            self._align(data.itemsize)
        self._parts += data.tobytes()

    def _align(self, size: int) -> None:
        self._parts += bytes(-len(self._parts) % size)

    def finish(self) -> bytes:
        return _HEADER + bytes(self._parts)


class _Reader:
    """Read CDR as `_Writer` writes it."""

    def __init__(self, data: bytes) -> None:
        if data[:4] != _HEADER:
            raise InputError(f"a message must be little-endian CDR, got header {data[:4].hex()}")
        self._data, self._place = data[4:], 0

    def number(self, code: str) -> float:
        size = struct.calcsize(f"<{code}")
        self._place += -self._place % size
        (value,) = struct.unpack(f"<{code}", self._take(size))
        return value

    def text(self) -> str:
        return self._take(int(self.number("I")))[:-1].decode()

    def array(self, dtype: str) -> np.ndarray:
        count = int(self.number("I"))
        size = np.dtype(dtype).itemsize
        if count:
            self._place += -self._place % size
        return np.frombuffer(self._take(count * size), dtype)

    def _take(self, size: int) -> bytes:
        data = self._data[self._place : self._place + size]
        if len(data) < size:
            raise InputError(f"a message ends {size - len(data)} bytes too early")
        self._place += size
        return data


def encode_info(info: SensorInfo) -> bytes:
    """Encode a sensor's description."""
    rows, columns = info.array.grid or (0, 0)
    writer = _Writer()
    writer.text(info.name)
    writer.number("d", info.rate)
    for value in (info.bits, info.shear, rows, columns):
        writer.number("I", int(value))
    for values in (info.array.positions, info.array.normals, info.array.areas):
        writer.array("<f8", values)
    writer.array("<u4", info.array.neighbours)
    return writer.finish()


def decode_info(data: bytes) -> SensorInfo:
    """Decode a sensor's description.

    Raises
    ------
    InputError
        If the message is damaged or its values are wrong.
    """
    reader = _Reader(data)
    name, rate = reader.text(), reader.number("d")
    bits, shear, rows, columns = (int(reader.number("I")) for _ in range(4))
    positions, normals = (reader.array("<f8").reshape(-1, 3) for _ in range(2))
    areas, pairs = reader.array("<f8"), reader.array("<u4").astype(np.int32).reshape(-1, 2)
    grid = (rows, columns) if rows else None
    mean = float(areas.mean()) if areas.size else np.nan
    array = TactileArray(positions, normals, mean, pairs, areas, grid)
    return SensorInfo(name, array, rate, bits, bool(shear))


def encode_frame(frame: TactileFrame) -> bytes:
    """Encode an image."""
    writer = _Writer()
    writer.number("d", frame.time)
    writer.array("<u2", frame.raw)
    writer.array("<f4", [] if frame.shear is None else frame.shear)
    return writer.finish()


def decode_frame(data: bytes) -> TactileFrame:
    """Decode an image.

    Raises
    ------
    InputError
        If the message is damaged.
    """
    reader = _Reader(data)
    time, raw, shear = reader.number("d"), reader.array("<u2"), reader.array("<f4")
    stress = shear.astype(np.float64).reshape(-1, 2) if shear.size else None
    return TactileFrame(time, raw.astype(np.uint16), stress)

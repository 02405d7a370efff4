"""PCD, the file format of the Point Cloud Library, version 0.7 and older.

open3d's readers do not replace this one. They drop WIDTH and HEIGHT, so that an organised cloud
loses its pixel grid. They return zeros for 64-bit coordinates and accept files that are truncated.
The tensor reader corrupts memory on padding fields. On a 640 x 480 cloud they take 4 to 5 times as
long (open3d 0.20: 65 ms and 87 ms, against 16 ms here).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .input_file import MAX_FILE_BYTES, naming, read_bytes
from .lzf import unpack_lzf
from .point_table import (
    LITTLE_ENDIAN_RECORD,
    PointTable,
    as_coordinates,
    as_float32,
    check_point_count,
    parse_rows,
    unpack_rgb,
    whole_number,
)

FIELD_TYPES = {("F", 4), ("F", 8)} | {(kind, size) for kind in "IU" for size in (1, 2, 4, 8)}
"""Valid pairs of TYPE and SIZE."""

COLOUR_FIELDS = {"rgb", "rgba"}
"""Fields that hold 0xAARRGGBB, as an integer or as the bits of a float32."""

READ_FIELDS = {"x", "y", "z"} | COLOUR_FIELDS
"""Fields that are read. All others are skipped."""

HEADER_KEYS = (
    *("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT"),
    *("WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"),
)
"""First words of the header's lines."""

COMPRESSED_SIZES = 8
"""Bytes before compressed data: their size and the unpacked size, uint32 each."""

INT32_LOWEST = -(2**31)
"""Colours with alpha above 127 are negative if the field is declared I (signed) instead of U."""

OPAQUE = 0xFF << 24
"""Alpha of a written colour."""


@dataclass(frozen=True)
class _Header:
    names: list[str]
    record: np.dtype
    columns: dict[str, int]
    width: int
    height: int
    form: str
    body_at: int

    @property
    def count(self) -> int:
        return self.width * self.height


def read_pcd(path: Path | str) -> PointTable:
    """Read all points of a PCD file, in file order. Points without a reading are included.

    The VIEWPOINT line is ignored: many files hold a viewer's pose or a placeholder there.

    Raises
    ------
    InputError
        If the file is missing, is not PCD, is truncated, or holds a layout that cannot be read.
    """
    data = read_bytes(path)
    with naming(path):
        header = _parse_header(data)
        values = READERS[header.form](data, header)
        points = as_coordinates([values[axis] for axis in "xyz"])
        packed = next((values[name] for name in ("rgb", "rgba") if name in values), None)
        colours = None if packed is None else unpack_rgb(packed)
    return PointTable(points, colours, header.width, header.height)


def pcd_bytes(table: PointTable) -> bytes:
    """Encode points as a binary PCD file of x, y, z float32 and, with colours, packed rgba.

    Raises
    ------
    InputError
        If a coordinate is beyond float32.
    """
    points = as_float32(table.points)
    layout = list(LITTLE_ENDIAN_RECORD)
    if table.colours is not None:
        layout.append(("rgba", "<u4"))
    records = np.empty(len(points), dtype=layout)
    for axis, values in zip("xyz", points.T, strict=True):
        records[axis] = values
    if table.colours is not None:
        red, green, blue = table.colours.astype(np.uint32).T
        records["rgba"] = OPAQUE | (red << 16) | (green << 8) | blue
    return _header_bytes(table, coloured=table.colours is not None) + records.tobytes()


def _header_bytes(table: PointTable, *, coloured: bool) -> bytes:
    width = table.width or len(table.points)
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        f"FIELDS x y z{' rgba' * coloured}",
        f"SIZE 4 4 4{' 4' * coloured}",
        f"TYPE F F F{' U' * coloured}",
        f"COUNT 1 1 1{' 1' * coloured}",
        f"WIDTH {width}",
        f"HEIGHT {table.height}",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {width * table.height}",
        "DATA binary",
    ]
    return ("\n".join(lines) + "\n").encode("ascii")


def _parse_header(data: bytes) -> _Header:
    entries, body_at = _header_entries(data)
    names = entries.get("FIELDS", [])
    kinds = entries.get("TYPE", [])
    sizes = _integers(entries, "SIZE")
    counts = _integers(entries, "COUNT") if "COUNT" in entries else [1] * len(names)
    if not len(names) == len(kinds) == len(sizes) == len(counts):
        raise InputError(
            f"the PCD header gives {len(names)} FIELDS, {len(sizes)} SIZE, {len(kinds)} TYPE and "
            f"{len(counts)} COUNT, expected as many of each"
        )
    missing = [axis for axis in "xyz" if axis not in names]
    if missing:
        raise InputError(f"the PCD fields are {' '.join(names)}, expected x, y, z among them")
    record, columns = _record(names, kinds, sizes, counts)
    width, height, declared = (_integer(entries, key) for key in ("WIDTH", "HEIGHT", "POINTS"))
    if width * height != declared or declared < 1:
        raise InputError(
            f"the PCD header has {width} x {height} and {declared} points, "
            "expected WIDTH x HEIGHT = POINTS >= 1"
        )
    check_point_count(declared)
    form = " ".join(entries["DATA"])
    if form not in READERS:
        raise InputError(f"the PCD header has DATA {form}, expected one of {tuple(READERS)}")
    return _Header(names, record, columns, width, height, form, body_at)


def _header_entries(data: bytes) -> tuple[dict[str, list[str]], int]:
    entries: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in entries:
        end = data.find(b"\n", at)
        if end < 0:
            raise InputError("not a whole PCD file: its header has no DATA line")
        words = [word.decode("latin-1") for word in data[at:end].split()]
        at = end + 1
        if not words or words[0].startswith("#"):
            continue
        if words[0] not in HEADER_KEYS:
            raise InputError(
                f"not a PCD file: a header line begins with {words[0][:20]!r}, "
                f"expected one of {', '.join(HEADER_KEYS)}"
            )
        entries[words[0]] = words[1:]
    return entries, at


def _record(
    names: list[str], kinds: list[str], sizes: list[int], counts: list[int]
) -> tuple[np.dtype, dict[str, int]]:
    """Return the layout of one binary record, and the text column of each field that is read."""
    layout: list[tuple[str, str, tuple[int, ...]]] = []
    columns: dict[str, int] = {}
    column = 0
    for name, kind, size, count in zip(names, kinds, sizes, counts, strict=True):
        if (kind, size) not in FIELD_TYPES or count < 1:
            raise InputError(
                f"the PCD field {name} has TYPE {kind}, SIZE {size}, COUNT {count}, "
                "expected F 4 or 8, I or U 1 to 8, and a count >= 1"
            )
        if name in READ_FIELDS:
            if name in columns or count != 1:
                raise InputError(f"the PCD field {name} comes more than once, expected one each")
            if name in COLOUR_FIELDS and size != 4:
                raise InputError(f"the PCD field {name} has SIZE {size}, expected 4")
            columns[name] = column
        # Padding fields share the name "_". A NumPy record requires unique names.
        unique = name if name in READ_FIELDS else f"#{column}"
        layout.append((unique, f"<{kind.lower()}{size}", (count,)))
        column += count
    try:
        return np.dtype(layout), columns
    except ValueError as error:
        raise InputError(f"the PCD records are too large ({column} numbers a point)") from error


def _integers(entries: dict[str, list[str]], key: str) -> list[int]:
    words = entries.get(key, [])
    numbers = [number for word in words if (number := whole_number(word)) is not None]
    if len(numbers) < len(words):
        raise InputError(f"the PCD header has {key} {' '.join(words)}, expected whole numbers")
    return numbers


def _integer(entries: dict[str, list[str]], key: str) -> int:
    values = _integers(entries, key)
    if len(values) != 1:
        raise InputError(f"the PCD header gives {len(values)} values of {key}, expected 1")
    return values[0]


def _read_binary(data: bytes, header: _Header) -> dict[str, NDArray]:
    _check_length(len(data) - header.body_at, header.count * header.record.itemsize)
    records = np.frombuffer(data, header.record, header.count, header.body_at)
    return {name: records[name][:, 0] for name in header.columns}


def _read_ascii(data: bytes, header: _Header) -> dict[str, NDArray]:
    names = list(header.columns)
    text = data[header.body_at :].decode("latin-1")
    table = parse_rows(text, header.count, [header.columns[name] for name in names])
    values: dict[str, NDArray] = dict(zip(names, table.T, strict=True))
    for name in COLOUR_FIELDS & values.keys():
        if header.record[name].base.kind != "f":
            values[name] = _whole_colours(values[name], name)
    return values


def _read_compressed(data: bytes, header: _Header) -> dict[str, NDArray]:
    """Return the fields of LZF data: first all values of one field, then all of the next."""
    body = header.body_at + COMPRESSED_SIZES
    _check_length(len(data) - header.body_at, COMPRESSED_SIZES)
    packed, unpacked = (int(size) for size in np.frombuffer(data, "<u4", 2, header.body_at))
    expected = header.count * header.record.itemsize
    if unpacked != expected:
        raise InputError(
            f"the compressed PCD data unpack to {unpacked} bytes, expected {expected} bytes for "
            f"{header.count} points"
        )
    if unpacked > MAX_FILE_BYTES:
        raise InputError(
            f"the compressed PCD data unpack to {unpacked} bytes, expected at most {MAX_FILE_BYTES}"
        )
    _check_length(len(data) - body, packed)
    columns = unpack_lzf(data[body : body + packed], unpacked)
    values: dict[str, NDArray] = {}
    start = 0
    for name in header.record.names or ():
        field = header.record[name]
        if name in READ_FIELDS:
            values[name] = np.frombuffer(columns, field.base, header.count, start)
        start += header.count * field.itemsize
    return values


def _check_length(length: int, expected: int) -> None:
    if length < expected:
        raise InputError(
            f"the PCD file is truncated: {max(length, 0)} bytes of data, expected {expected}"
        )


def _whole_colours(values: NDArray[np.float64], name: str) -> NDArray[np.uint32]:
    if not ((values >= INT32_LOWEST) & (values < 2**32)).all():
        raise InputError(f"the PCD field {name} holds values that are not packed 32-bit colours")
    return values.astype(np.int64).astype(np.uint32)


READERS = {"ascii": _read_ascii, "binary": _read_binary, "binary_compressed": _read_compressed}
"""Reader of the data for each form that the header's DATA line may name."""

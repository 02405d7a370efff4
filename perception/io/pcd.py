"""PCD, the Point Cloud Library's file format, version 0.7 and its forerunners.

Plain records are a header and a table, which NumPy reads as they are. open3d does the
decompression only: its 0.20 readers return zeros for 64-bit coordinates and for words among
numbers, take half a file for a whole one, and the tensor one corrupts memory on padding fields.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from eyehand.errors import InputError

from .input_file import naming, read_bytes
from .open3d_import import import_open3d
from .point_table import (
    LITTLE_ENDIAN_RECORD,
    PointTable,
    as_coordinates,
    as_float32,
    parse_rows,
    unpack_rgb,
    whole_number,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

DATA_FORMS = ("ascii", "binary", "binary_compressed")
"""What the header's DATA line may say."""

FIELD_TYPES = {("F", 4), ("F", 8)} | {(kind, size) for kind in "IU" for size in (1, 2, 4, 8)}
"""Pairs of TYPE and SIZE that the format knows."""

COLOUR_FIELDS = {"rgb", "rgba"}
"""Fields that hold 0xAARRGGBB, as an integer or in the bits of a float32."""

READ_FIELDS = {"x", "y", "z"} | COLOUR_FIELDS
"""Fields that matter here; all others are skipped."""

HEADER_KEYS = (
    *("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT"),
    *("WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA"),
)
"""First words of the header's lines."""

COMPRESSED_SIZES = 8
"""Bytes before compressed data: their size and the unpacked size, uint32 each."""

INT32_LOWEST = -(2**31)
"""Colours with alpha above 127 are negative where they are declared I instead of U."""

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
    """All points of a PCD file, in file order, those without a reading too.

    The VIEWPOINT line is not read: files in the wild hold a viewer's or nobody's pose there.

    Raises
    ------
    InputError
        If the file is missing, is not PCD, is cut short, or holds a layout that cannot be read.
    DeviceError
        If the data are compressed and open3d cannot be loaded.
    """
    data = read_bytes(path)
    with naming(path):
        header = _parse_header(data)
        if header.form == "binary_compressed":
            return _read_compressed(data, header)
        values = _read_ascii(data, header) if header.form == "ascii" else _read_binary(data, header)
        points = as_coordinates([values[axis] for axis in "xyz"])
        packed = next((values[name] for name in ("rgb", "rgba") if name in values), None)
        colours = None if packed is None else unpack_rgb(packed)
    return PointTable(points, colours, header.width, header.height)


def pcd_bytes(table: PointTable) -> bytes:
    """Binary PCD file of x, y, z float32 and, when there are colours, packed rgba.

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
    header = _header_bytes(records.dtype, table.width or len(points), table.height, "binary")
    return header + records.tobytes()


def _header_bytes(record: np.dtype, width: int, height: int, form: str) -> bytes:
    names = list(record.names or ())
    fields = [record[name] for name in names]
    # A colour declared I is a colour declared U with another reading of alpha's top bit.
    kinds = [
        "U" if name in COLOUR_FIELDS and field.base.kind == "i" else field.base.kind.upper()
        for name, field in zip(names, fields, strict=True)
    ]
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "VERSION 0.7",
        f"FIELDS {' '.join(name if name in READ_FIELDS else '_' for name in names)}",
        f"SIZE {' '.join(str(field.base.itemsize) for field in fields)}",
        f"TYPE {' '.join(kinds)}",
        f"COUNT {' '.join(str(field.shape[0] if field.shape else 1) for field in fields)}",
        f"WIDTH {width}",
        f"HEIGHT {height}",
        "VIEWPOINT 0 0 0 1 0 0 0",
        f"POINTS {width * height}",
        f"DATA {form}",
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
            f"the PCD header says {width} x {height} and {declared} points, "
            "expected WIDTH x HEIGHT = POINTS >= 1"
        )
    form = " ".join(entries["DATA"])
    if form not in DATA_FORMS:
        raise InputError(f"the PCD header says DATA {form}, expected one of {DATA_FORMS}")
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
    """Layout of one binary record, and the text column of each field that is read."""
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
        # Padding fields share the name "_", which a NumPy record does not allow.
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
        raise InputError(f"the PCD header says {key} {' '.join(words)}, expected whole numbers")
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


def _read_compressed(data: bytes, header: _Header) -> PointTable:
    for axis in "xyz":
        field = header.record[axis].base
        if field != np.dtype("<f4"):
            raise InputError(
                f"the compressed PCD field {axis} has type {field}, expected 4-byte F: "
                "save the file as binary"
            )
    body = header.body_at
    _check_length(len(data) - body, COMPRESSED_SIZES)
    packed, unpacked = (int.from_bytes(data[at : at + 4], "little") for at in (body, body + 4))
    expected = header.count * header.record.itemsize
    if unpacked != expected:
        raise InputError(
            f"the compressed PCD data unpack to {unpacked} bytes, expected {expected} bytes for "
            f"{header.count} points"
        )
    _check_length(len(data) - body - COMPRESSED_SIZES, packed)
    cloud = _unpack(
        _header_bytes(header.record, header.width, header.height, header.form), data[body:]
    )
    points = np.asarray(cloud.points)
    if len(points) != header.count:
        raise InputError("the compressed PCD data are damaged: they do not unpack")
    # Exact: open3d widens the stored float32 and divides the stored bytes by 255.
    colours = np.rint(np.asarray(cloud.colors) * 255).astype(np.uint8) if cloud.colors else None
    return PointTable(points.astype(np.float32), colours, header.width, header.height)


def _unpack(header: bytes, body: bytes) -> Any:
    """open3d's point cloud of compressed data under a header of our own writing.

    Its parser splits lines in other places than ours and returns memory that it never wrote where
    it finds no DATA form: what it sees must be what was checked.
    """
    open3d = import_open3d()
    with (
        TemporaryDirectory() as folder,
        open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error),
    ):
        copy = Path(folder) / "cloud.pcd"
        copy.write_bytes(header + body)
        return open3d.io.read_point_cloud(
            str(copy), remove_nan_points=False, remove_infinite_points=False
        )


def _check_length(length: int, expected: int) -> None:
    if length < expected:
        raise InputError(
            f"the PCD file is cut short: {max(length, 0)} bytes of data, expected {expected}"
        )


def _whole_colours(values: NDArray[np.float64], name: str) -> NDArray[np.uint32]:
    if not ((values >= INT32_LOWEST) & (values < 2**32)).all():
        raise InputError(f"the PCD field {name} holds values that are not packed 32-bit colours")
    return values.astype(np.int64).astype(np.uint32)

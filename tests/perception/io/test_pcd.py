"""Tests of PCD files: all layouts are read, broken files are rejected."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.open3d_import import import_open3d
from eyehand.errors import InputError
from eyehand.perception.io.pcd import read_pcd
from eyehand.perception.io.point_table import PointTable

COLOUR = (10 << 16) | (20 << 8) | 30
POINTS = np.array([[1, 2, 3], [np.nan, np.nan, np.nan], [4, 5, 6], [7, 8, 9.5]], dtype=np.float32)


def _header(
    fields: str = "x y z",
    size: str = "4 4 4",
    kind: str = "F F F",
    count: str = "1 1 1",
    grid: tuple[int, int] = (2, 1),
    form: str = "binary",
) -> bytes:
    return (
        f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {fields}\nSIZE {size}\n"
        f"TYPE {kind}\nCOUNT {count}\nWIDTH {grid[0]}\nHEIGHT {grid[1]}\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {grid[0] * grid[1]}\nDATA {form}\n"
    ).encode("latin-1")


def _read(tmp_path: Path, data: bytes) -> PointTable:
    (tmp_path / "a.pcd").write_bytes(data)
    return read_pcd(tmp_path / "a.pcd")


@pytest.mark.parametrize(
    "options", [{}, {"write_ascii": True}, {"compressed": True}], ids=["plain", "ascii", "packed"]
)
def test_open3d_file_is_read_in_order(tmp_path: Path, options: dict[str, bool]) -> None:
    open3d = import_open3d()
    points = np.random.default_rng(3).normal(size=(500, 3)).astype(np.float32)
    colours = np.random.default_rng(4).integers(0, 256, (500, 3), dtype=np.uint8)
    points[17] = np.nan
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points.astype(np.float64)))
    cloud.colors = open3d.utility.Vector3dVector(colours / 255)
    assert open3d.io.write_point_cloud(str(tmp_path / "a.pcd"), cloud, **options)
    table = read_pcd(tmp_path / "a.pcd")
    # Open3D writes ten digits, more than float32 needs.
    np.testing.assert_array_equal(table.points.astype(np.float32), points)
    np.testing.assert_array_equal(table.colours, colours)


@pytest.mark.parametrize(("name", "kind"), [("rgb", "F"), ("rgb", "U"), ("rgba", "U")])
def test_packed_colours_are_rgb(tmp_path: Path, name: str, kind: str) -> None:
    header = _header(f"x y z {name}", "4 4 4 4", f"F F F {kind}", "1 1 1 1")
    table = _read(tmp_path, header + struct.pack("<fffI", 1, 2, 3, COLOUR) * 2)
    np.testing.assert_array_equal(table.colours, [[10, 20, 30]] * 2)
    value = f"{struct.unpack('<f', struct.pack('<I', COLOUR))[0]!r}" if kind == "F" else COLOUR
    header = _header(f"x y z {name}", "4 4 4 4", f"F F F {kind}", "1 1 1 1", form="ascii")
    table = _read(tmp_path, header + f"1 2 3 {value}\n1 2 3 {value}\n".encode())
    np.testing.assert_array_equal(table.colours, [[10, 20, 30]] * 2)


def test_padding_fields_are_skipped(tmp_path: Path) -> None:
    header = _header("x y z _ rgb _", "4 4 4 1 4 1", "F F F U F U", "1 1 1 4 1 12")
    row = struct.pack("<fff4xI12x", 1, 2, 3, COLOUR)
    table = _read(tmp_path, header + row * 2)
    np.testing.assert_array_equal(table.points, [[1, 2, 3]] * 2)
    np.testing.assert_array_equal(table.colours, [[10, 20, 30]] * 2)


def test_padding_fields_are_skipped_in_compressed_data(tmp_path: Path) -> None:
    header = _header(
        "x y z _ rgb _", "4 4 4 1 4 1", "F F F U I U", "1 1 1 4 1 12", form="binary_compressed"
    )
    columns = struct.pack("<6f8x2I24x", 1, 2, 3, 4, 5, 6, COLOUR, COLOUR)
    table = _read(tmp_path, header + _compress(columns))
    np.testing.assert_array_equal(table.points, [[1, 3, 5], [2, 4, 6]])
    np.testing.assert_array_equal(table.colours, [[10, 20, 30]] * 2)


def test_compressed_doubles_are_read(tmp_path: Path) -> None:
    header = _header(size="8 8 8", form="binary_compressed")
    table = _read(tmp_path, header + _compress(struct.pack("<6d", 0.1, 1, 2, 3, 4, 5)))
    np.testing.assert_array_equal(table.points, [[0.1, 2, 4], [1, 3, 5]])


def test_doubles_and_other_field_orders_are_read(tmp_path: Path) -> None:
    table = _read(tmp_path, _header("z y x", "8 8 8") + struct.pack("<3d", 3, 2, 0.1) * 2)
    np.testing.assert_array_equal(table.points, [[0.1, 2, 3]] * 2)


def test_ascii_accepts_windows_line_ends_and_nan(tmp_path: Path) -> None:
    text = _header(grid=(2, 2), form="ascii") + b"1 2 3\nnan nan nan\n4 5 6\n7 8 9.5\n"
    table = _read(tmp_path, text.replace(b"\n", b"\r\n"))
    np.testing.assert_array_equal(table.points, POINTS)
    assert (table.width, table.height) == (2, 2)


ASCII = _header(form="ascii") + b"1 2 3\n4 5 6\n"
BINARY = _header() + struct.pack("<6f", *range(6))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"junk\nmore\n", r"a\.pcd: not a PCD file: a header line begins with 'junk'"),
        (b"VERSION 0.7\n", "not a whole PCD file: its header has no DATA line"),
        (BINARY[:-1], r"truncated: 23 bytes of data, expected 24"),
        (ASCII[:-6], r"truncated: holds 1 of the 2 points"),
        (ASCII.replace(b"5", b"five"), "not a table of numbers .*five"),
        (BINARY.replace(b"x y z", b"a y z"), "PCD fields are a y z, expected x, y, z among them"),
        (BINARY.replace(b"x y z", b"x y"), "gives 2 FIELDS, 3 SIZE, 3 TYPE and 3 COUNT"),
        (BINARY.replace(b"x y z", b"x y z z"), "gives 4 FIELDS, 3 SIZE"),
        (BINARY.replace(b"F F F", b"F F Q"), "field z has TYPE Q, SIZE 4, COUNT 1"),
        (BINARY.replace(b"T 1 1 1", b"T 1 1 2"), "field z comes more than once"),
        (BINARY.replace(b"WIDTH 2", b"WIDTH 3"), "has 3 x 1 and 2 points"),
        (BINARY.replace(b"WIDTH 2", b"WIDTH two"), "has WIDTH two, expected whole numbers"),
        (BINARY.replace(b"WIDTH 2\n", b""), "gives 0 values of WIDTH, expected 1"),
        (BINARY.replace(b"DATA binary", b"DATA gzip"), "has DATA gzip, expected one of"),
        (BINARY.replace(b" 2\n", b" 0\n"), "has 0 x 1 and 0 points"),
        (BINARY.replace(b" 2\n", b" 400000000\n"), "holds 400000000 points, expected at most"),
        (BINARY.replace(b"T 1 1 1", b"T 1 1 1" + b"0" * 5000), "expected whole numbers"),
    ],
)
def test_broken_files_are_rejected(tmp_path: Path, data: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        _read(tmp_path, data)


def test_broken_compressed_files_are_rejected(tmp_path: Path) -> None:
    header = _header(form="binary_compressed")
    body = _compress(struct.pack("<6f", *range(6)))
    np.testing.assert_array_equal(_read(tmp_path, header + body).points, [[0, 2, 4], [1, 3, 5]])
    for data, message in (
        (header, "truncated: 0 bytes of data, expected 8"),
        (header + body[:-1], "truncated: 24 bytes of data, expected 25"),
        (header + body.replace(b"\x18", b"\x17", 1), "unpack to 23 bytes, expected 24 bytes"),
        (header + body[:8] + b"\xff" * 25, "damaged: they must decompress to"),
        # U+0085 ends a line for str.splitlines, but not for other readers.
        (header.replace(b"DATA ", b"DATA\x85") + body, r"begins with 'DATA\\x85binary"),
    ):
        with pytest.raises(InputError, match=message):
            _read(tmp_path, data)


def _compress(data: bytes) -> bytes:
    """Return an LZF stream of literals only, valid for every decoder."""
    runs = [data[i : i + 32] for i in range(0, len(data), 32)]
    packed = b"".join(bytes([len(run) - 1]) + run for run in runs)
    return struct.pack("<II", len(packed), len(data)) + packed

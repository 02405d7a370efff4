"""Tests of PLY files: points, colours, and the two encodings of an organised grid."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from eyehand.apps.open3d_import import import_open3d
from eyehand.errors import InputError
from eyehand.perception.io.ply import read_ply
from eyehand.perception.io.point_table import PointTable

RGB = "property uchar red\nproperty uchar green\nproperty uchar blue\n"


def _header(form: str = "ascii", count: int = 2, before: str = "", after: str = "") -> bytes:
    return (
        f"ply\nformat {form} 1.0\n{before}element vertex {count}\nproperty float x\n"
        f"property float y\nproperty float z\n{after}end_header\n"
    ).encode()


def _read(tmp_path: Path, data: bytes) -> PointTable:
    (tmp_path / "a.ply").write_bytes(data)
    return read_ply(tmp_path / "a.ply")


@pytest.mark.parametrize("ascii_form", [False, True])
def test_open3d_file_is_read_in_order(tmp_path: Path, ascii_form: bool) -> None:
    open3d = import_open3d()
    points = np.random.default_rng(3).normal(size=(100, 3)).astype(np.float32)
    colours = np.random.default_rng(4).integers(0, 256, (100, 3), dtype=np.uint8)
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points.astype(np.float64)))
    cloud.colors = open3d.utility.Vector3dVector(colours / 255)
    assert open3d.io.write_point_cloud(str(tmp_path / "a.ply"), cloud, write_ascii=ascii_form)
    table = read_ply(tmp_path / "a.ply")
    tolerance = 1e-5 if ascii_form else 0.0  # Open3D writes six digits
    np.testing.assert_allclose(table.points, points, atol=tolerance)
    np.testing.assert_array_equal(table.colours, colours)


def test_big_endian_file_with_preceding_table_is_read(tmp_path: Path) -> None:
    header = _header("binary_big_endian", before="element camera 1\nproperty double f\n", after=RGB)
    row = struct.pack(">fff3B", 1, 2, 3, 10, 20, 30)
    table = _read(tmp_path, header + struct.pack(">d", 9.0) + row * 2)
    np.testing.assert_array_equal(table.points, [[1, 2, 3]] * 2)
    np.testing.assert_array_equal(table.colours, [[10, 20, 30]] * 2)


def test_ascii_tables_before_points_are_skipped(tmp_path: Path) -> None:
    header = _header(before="element camera 1\nproperty double f\n", after=RGB)
    table = _read(tmp_path, header + b"9\n1 2 3 10 20 30\n4 5 nan 255 0 1\n")
    np.testing.assert_array_equal(table.points, [[1, 2, 3], [4, 5, np.nan]])
    np.testing.assert_array_equal(table.colours, [[10, 20, 30], [255, 0, 1]])


def test_diffuse_and_fractional_colours_are_read(tmp_path: Path) -> None:
    diffuse = RGB.replace("uchar ", "uchar diffuse_")
    rows = b"1 2 3 10 20 30\n" * 2
    np.testing.assert_array_equal(
        _read(tmp_path, _header(after=diffuse) + rows).colours, [[10, 20, 30]] * 2
    )
    fractions = _header(after=RGB.replace("uchar", "float")) + b"1 2 3 0.2 0.4 1\n" * 2
    np.testing.assert_array_equal(_read(tmp_path, fractions).colours, [[51, 102, 255]] * 2)


@pytest.mark.parametrize(
    "lines",
    ["obj_info num_cols 3\nobj_info num_rows 2\n", "comment width 3\ncomment height 2\n"],
)
def test_grid_size_is_read_from_header(tmp_path: Path, lines: str) -> None:
    table = _read(tmp_path, _header(count=6, before=lines) + b"1 2 3\n" * 6)
    assert (table.width, table.height) == (3, 2)


GRID = "obj_info num_cols 2\nobj_info num_rows 2\n"
RANGE_GRID = "element range_grid 4\nproperty list uchar int vertex_indices\n"
ASCII_GRID = _header(before=GRID, after=RGB + RANGE_GRID) + (
    b"1 2 3 10 20 30\n4 5 6 7 8 9\n1 1\n0\n0\n1 0\n"
)


def test_range_grid_assigns_points_to_pixels(tmp_path: Path) -> None:
    missing = [np.nan] * 3
    header = _header("binary_little_endian", before=GRID, after=RGB + RANGE_GRID)
    rows = struct.pack("<3f3B3f3B", 1, 2, 3, 10, 20, 30, 4, 5, 6, 7, 8, 9)
    binary = header + rows + struct.pack("<BiBBBi", 1, 1, 0, 0, 1, 0)
    for data in (ASCII_GRID, binary):
        table = _read(tmp_path, data)
        np.testing.assert_array_equal(table.points, [[4, 5, 6], missing, missing, [1, 2, 3]])
        assert table.colours is not None
        np.testing.assert_array_equal(table.colours[[0, 3]], [[7, 8, 9], [10, 20, 30]])
        assert (table.width, table.height) == (2, 2)
    with pytest.raises(InputError, match="truncated: 3 of 4 rows of range_grid"):
        _read(tmp_path, binary[:-1])


ASCII = _header() + b"1 2 3\n4 5 6\n"
BINARY = _header("binary_little_endian") + struct.pack("<6f", *range(6))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"plywood\n", r"a\.ply: not a PLY file: it begins with b'plywood"),
        (ASCII[:60], "not a whole PLY file: its header has no end_header line"),
        (BINARY[:-1], r"truncated: \d+ bytes, expected \d+ for 2 vertices"),
        (ASCII[:-6], "truncated: holds 1 of the 2 points"),
        (ASCII.replace(b"5", b"five"), "not a table of numbers .*five"),
        (ASCII.replace(b"ascii", b"utf8"), r"format is 'utf8', expected one of \['ascii'"),
        (ASCII.replace(b"float x", b"float a"), "vertices have a y z, expected x, y, z, once each"),
        (ASCII.replace(b"float y", b"float x"), "vertices have x x z, expected x, y, z, once"),
        (ASCII.replace(b"float z", b"half z"), "has 'property half z', which is not PLY"),
        (ASCII.replace(b"vertex 2", b"vertex two"), "has element vertex two, expected a whole"),
        (ASCII.replace(b"vertex 2", b"vertex 0"), "holds 0 PLY vertices, expected at least 1"),
        (ASCII.replace(b"vertex 2", b"corner 2"), "holds no PLY vertices"),
        (ASCII.replace(b"vertex 2", b"vertex 400000000"), "holds 400000000 points, expected at"),
        (_header(after="property list uchar int i\n") + b"1 2 3 0\n" * 2, "lists before or in its"),
        (_header(after=RGB) + b"1 2 3 0 0 256\n" * 2, "blue holds values outside 0 to 255"),
        (
            _header(after=RGB.replace("uchar", "float")) + b"1 2 3 0 0 2\n" * 2,
            "colours are float64, expected uchar or float 0 to 1",
        ),
        (ASCII_GRID.replace(b"num_cols 2", b"num_cols 3"), "has 4 cells, expected .* = 3 x 2"),
        (
            ASCII_GRID.replace(b"\n1 1\n", b"\n1 2\n"),
            "range_grid table refers to vertices 0 to 2, expected 0 to 1",
        ),
        (ASCII_GRID.replace(b"\n1 1\n", b"\n2 1 0\n"), "cell has 2 vertices, expected 0 or 1"),
        (ASCII_GRID[:-4], "truncated: 3 of 4 rows of range_grid"),
    ],
)
def test_broken_files_are_rejected(tmp_path: Path, data: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        _read(tmp_path, data)

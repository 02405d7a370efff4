"""Tests of PCD and PLY files: what is written is read back, and open3d reads it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from eyehand.apps.open3d_import import import_open3d
from eyehand.errors import InputError
from eyehand.perception.io.pcd import pcd_bytes, read_pcd
from eyehand.perception.io.ply import ply_bytes, read_ply
from eyehand.perception.io.point_table import PointTable

POINTS = np.array([[1, 2, 3], [np.nan, np.nan, np.nan], [4, 5, 6], [7, 8, 9.5]], dtype=np.float32)
COLOURS = np.array([[10, 20, 30], [0, 0, 0], [255, 0, 1], [7, 8, 9]], dtype=np.uint8)


class Format(NamedTuple):
    """A file format of clouds: its suffix, writer and reader."""

    suffix: str
    encode: Callable[[PointTable], bytes]
    read: Callable[[Path], PointTable]

    def read_bytes(self, folder: Path, data: bytes) -> PointTable:
        """Write a file and read it."""
        path = folder / f"a{self.suffix}"
        path.write_bytes(data)
        return self.read(path)


FORMATS = [Format(".pcd", pcd_bytes, read_pcd), Format(".ply", ply_bytes, read_ply)]
each_format = pytest.mark.parametrize("form", FORMATS, ids=lambda form: form.suffix)


@each_format
@settings(deadline=None, max_examples=30)
@given(
    points=hnp.arrays(np.float32, st.tuples(st.integers(1, 12), st.just(3))),
    coloured=st.booleans(),
)
def test_written_cloud_is_read_back_exactly(
    tmp_path_factory: pytest.TempPathFactory, form: Format, points: np.ndarray, coloured: bool
) -> None:
    points[np.isinf(points)] = np.nan
    colours = (np.arange(points.size) * 37 % 256).astype(np.uint8).reshape(points.shape)
    # PCD files without a grid are one row. PLY files state a grid only if it is known.
    grid = (len(points), 1) if form.suffix == ".ply" else ()
    table = PointTable(points, colours if coloured else None, *grid)
    back = form.read_bytes(tmp_path_factory.mktemp("cloud"), form.encode(table))
    np.testing.assert_array_equal(back.points, points)
    assert (back.width, back.height) == (len(points), 1)
    if coloured:
        np.testing.assert_array_equal(back.colours, colours)
    else:
        assert back.colours is None


@each_format
def test_open3d_reads_written_file(tmp_path: Path, form: Format) -> None:
    path = tmp_path / f"a{form.suffix}"
    path.write_bytes(form.encode(PointTable(POINTS, COLOURS, 2, 2)))
    cloud = import_open3d().io.read_point_cloud(str(path), remove_nan_points=False)
    np.testing.assert_array_equal(np.asarray(cloud.points), POINTS)
    np.testing.assert_array_equal(np.rint(np.asarray(cloud.colors) * 255), COLOURS)


@each_format
def test_truncated_binary_file_is_rejected(tmp_path: Path, form: Format) -> None:
    whole = form.encode(PointTable(POINTS, COLOURS, 2, 2))
    for keep in range(len(whole)):
        with pytest.raises(InputError):
            form.read_bytes(tmp_path, whole[:keep])

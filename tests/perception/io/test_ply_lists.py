"""Tests of reading vertex lists from ASCII and binary PLY data."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.errors import InputError
from eyehand.perception.io.ply import read_vertex_lists
from eyehand.perception.io.ply_header import PlyElement, PlyHeader, PlyProperty

LIST = PlyProperty("vertex_indices", "i4", "u1")
FLAGS = PlyProperty("flags", "i2")
TEXTURE = PlyProperty("texcoord", "f4", "u1")


def _header(form: str, rows: int, columns: list[PlyProperty]) -> tuple[PlyHeader, PlyElement]:
    face = PlyElement("face", rows, columns)
    return PlyHeader(form, [PlyElement("vertex", 9), face]), face


@given(st.lists(st.lists(st.integers(0, 8), max_size=6), max_size=5), st.sampled_from("<>"))
def test_lists_between_other_columns_are_read(faces: list[list[int]], order: str) -> None:
    form = "binary_little_endian" if order == "<" else "binary_big_endian"
    header, face = _header(form, len(faces), [FLAGS, TEXTURE, LIST, FLAGS])
    data = b"skipped" + b"".join(
        struct.pack(f"{order}hBffB{len(f)}ih", 7, 2, 0.5, 0.5, len(f), *f, 7) for f in faces
    )
    assert read_vertex_lists(data, header, face, 7) == faces
    header, face = _header("ascii", len(faces), [FLAGS, TEXTURE, LIST, FLAGS])
    text = "a vertex\n" + "".join(
        f"7 2 0.5 0.5 {len(f)} {' '.join(map(str, f))} 7\n" for f in faces
    )
    assert read_vertex_lists(text.encode(), header, face, 1) == faces


def test_truncated_data_is_rejected() -> None:
    header, face = _header("binary_little_endian", 2, [LIST, FLAGS])
    data = struct.pack("<B3ihB3ih", 3, 0, 1, 2, 7, 3, 0, 1, 2, 7)
    for keep in range(len(data)):
        with pytest.raises(InputError, match=r"truncated: [01] of 2 rows of face"):
            read_vertex_lists(data[:keep], header, face, 0)


@pytest.mark.parametrize("row", ["3 0 1", "-1 0", "2 0 x", "", "1 -1"])
def test_rows_without_list_are_rejected(row: str) -> None:
    header, face = _header("ascii", 1, [LIST])
    with pytest.raises(InputError, match=r"a PLY row is|truncated: 0 of 1 rows"):
        read_vertex_lists(f"{row}\n".encode(), header, face, 0)


@pytest.mark.parametrize("vertex", [-1, 9, 2**31 - 1])
def test_nonexistent_vertices_are_rejected(vertex: int) -> None:
    header, face = _header("binary_little_endian", 1, [LIST])
    with pytest.raises(InputError, match=r"face table refers to vertices .* expected 0 to 8"):
        read_vertex_lists(struct.pack("<B3i", 3, 0, 1, vertex), header, face, 0)


@pytest.mark.parametrize("columns", [[FLAGS], [TEXTURE], [LIST, LIST]])
def test_table_without_single_vertex_list_is_rejected(columns: list[PlyProperty]) -> None:
    header, face = _header("ascii", 1, columns)
    with pytest.raises(InputError, match="the PLY face table must follow the vertices and have"):
        read_vertex_lists(b"3 0 1 2\n", header, face, 0)


def test_table_not_after_vertices_is_rejected() -> None:
    header, face = _header("ascii", 1, [LIST])
    header.elements.insert(1, PlyElement("edge", 1, [FLAGS]))
    with pytest.raises(InputError, match="must follow the vertices"):
        read_vertex_lists(b"3 0 1 2\n", header, face, 0)

"""Read the lists of vertex indices in PLY files, for faces and for pixel grids.

open3d 0.20 cannot replace this reader, because open3d uses vertex indices before it checks them.
"""

from __future__ import annotations

import struct

import numpy as np

from eyehand.errors import InputError

from .ply_header import PlyElement, PlyHeader, PlyProperty
from .point_table import whole_number

STRUCT_CODES = {
    **{"i1": "b", "u1": "B", "i2": "h", "u2": "H"},
    **{"i4": "i", "u4": "I", "f4": "f", "f8": "d"},
}
"""Codes of the struct module for NumPy types of the same size."""


def read_vertex_lists(
    data: bytes, header: PlyHeader, element: PlyElement, start: int
) -> list[list[int]]:
    """Read the vertex list of each row of a table, and skip the other columns.

    Parameters
    ----------
    data : bytes
        The whole file.
    header : PlyHeader
        The header of the file.
    element : PlyElement
        The table, which must follow the vertices.
    start : int
        Start of the table: a byte offset in the file, or a line number in an ASCII body.

    Raises
    ------
    InputError
        If the table does not follow the vertices, does not have exactly one list of integers, is
        truncated, or refers to a vertex that does not exist.
    """
    names = [e.name for e in header.elements]
    vertex = header.elements[names.index("vertex")]
    lists = [p for p in element.properties if p.count_kind and p.kind[0] != "f"]
    if names.index(element.name) != names.index("vertex") + 1 or len(lists) != 1:
        raise InputError(
            f"the PLY {element.name} table must follow the vertices and have one list of vertices"
        )
    if header.form == "ascii":
        lines = [x for x in data[header.body_at :].decode("latin-1").splitlines() if x.strip()]
        rows = [
            _text_row(line.split(), element.properties, lists[0])
            for line in lines[start : start + element.count]
        ]
    else:
        rows = _binary_rows(data, header.byte_order, element, lists[0], start)
    if len(rows) < element.count:
        raise InputError(
            f"the PLY file is truncated: {len(rows)} of {element.count} rows of {element.name}"
        )
    _check_vertices(rows, vertex.count, element.name)
    return rows


def _check_vertices(rows: list[list[int]], count: int, name: str) -> None:
    lowest = min((min(row) for row in rows if row), default=0)
    highest = max((max(row) for row in rows if row), default=0)
    if lowest < 0 or highest >= count:
        raise InputError(
            f"the PLY {name} table refers to vertices {lowest} to {highest}, "
            f"expected 0 to {count - 1}"
        )


def _text_row(
    words: list[str], properties: list[PlyProperty], list_column: PlyProperty
) -> list[int]:
    at = 0
    for column in properties:
        length = 1
        if column.count_kind:
            length = whole_number(words[at]) if at < len(words) else None
            at += 1
        if length is None or at + length > len(words):
            break
        if column is list_column:
            vertices = [whole_number(word) for word in words[at : at + length]]
            if None not in vertices:
                return [v for v in vertices if v is not None]
            break
        at += length
    raise InputError(f"a PLY row is {' '.join(words)[:40]!r}, expected a list of whole numbers")


def _binary_rows(
    data: bytes, order: str, element: PlyElement, list_column: PlyProperty, start: int
) -> list[list[int]]:
    at = start
    rows: list[list[int]] = []
    sizes = {kind: np.dtype(kind).itemsize for kind in STRUCT_CODES}
    counts = {
        p: struct.Struct(order + STRUCT_CODES[p.count_kind or "u1"]) for p in element.properties
    }
    for _ in range(element.count):
        row: list[int] = []
        for column in element.properties:
            length = 1
            if column.count_kind:
                if at + counts[column].size > len(data):
                    return rows
                (length,) = counts[column].unpack_from(data, at)
                at += counts[column].size
            end = at + length * sizes[column.kind]
            if length < 0 or end > len(data):
                return rows
            if column is list_column:
                row = list(
                    struct.unpack_from(f"{order}{length}{STRUCT_CODES[column.kind]}", data, at)
                )
            at = end
        rows.append(row)
    return rows

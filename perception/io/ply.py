"""PLY, the polygon file format: points, colours, pixel grids and faces.

open3d's readers do not replace this one. They drop the pixel grid, and for a file that is truncated
they return as many points as its header declares. On a 640 x 480 cloud they take 15 times as long
(open3d 0.20: 47 ms and 49 ms, against 3 ms here). They use vertex indices before they check them.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .input_file import naming, read_bytes
from .ply_header import PlyElement, PlyHeader, PlyProperty, parse_ply_header
from .point_table import (
    LITTLE_ENDIAN_RECORD,
    PointTable,
    as_coordinates,
    as_float32,
    check_point_count,
    parse_rows,
    whole_number,
)

COLOUR_NAMES = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
"""Property names of colours, the usual ones first."""


def read_ply(path: Path | str) -> PointTable:
    """Read all vertices of a PLY file. A range grid gives them in pixel order, with NaN for gaps.

    Raises
    ------
    InputError
        If the file is missing, is not PLY, is truncated, or holds a layout that cannot be read.
    """
    data = read_bytes(path)
    with naming(path):
        header = parse_ply_header(data)
        table, end = _read_points(data, header)
        grid = header.element("range_grid")
        if grid is None:
            return table
        check_point_count(grid.count)
        return _scatter(table, read_vertex_lists(data, header, grid, end))


def read_ply_faces(path: Path | str) -> tuple[NDArray[np.floating], list[list[int]]]:
    """Read the vertices (N, 3), m, and the vertex indices of each face of a PLY file.

    Raises
    ------
    InputError
        As `read_ply`, or if a face names a vertex that does not exist.
    """
    data = read_bytes(path)
    with naming(path):
        header = parse_ply_header(data)
        table, end = _read_points(data, header)
        faces = header.element("face")
        if faces is None:
            return table.points, []
        return table.points, read_vertex_lists(data, header, faces, end)


def ply_bytes(table: PointTable) -> bytes:
    """Encode points as a binary PLY file of x, y, z float32, with colours and grid size if known.

    Raises
    ------
    InputError
        If a coordinate is beyond float32.
    """
    points = as_float32(table.points)
    layout = list(LITTLE_ENDIAN_RECORD)
    header = ["ply", "format binary_little_endian 1.0"]
    if table.width:
        header += [f"obj_info num_cols {table.width}", f"obj_info num_rows {table.height}"]
    header += [f"element vertex {len(points)}"] + [f"property float {axis}" for axis in "xyz"]
    if table.colours is not None:
        layout += [(name, "u1") for name in COLOUR_NAMES[0]]
        header += [f"property uchar {name}" for name in COLOUR_NAMES[0]]
    records = np.empty(len(points), dtype=layout)
    for axis, values in zip("xyz", points.T, strict=True):
        records[axis] = values
    if table.colours is not None:
        for name, values in zip(COLOUR_NAMES[0], table.colours.T, strict=True):
            records[name] = values
    return ("\n".join(header) + "\nend_header\n").encode("ascii") + records.tobytes()


def _read_points(data: bytes, header: PlyHeader) -> tuple[PointTable, int]:
    """Return the vertices and their end: a byte offset, or a line number of an ASCII body."""
    vertex = header.element("vertex")
    if vertex is None or vertex.count < 1:
        raise InputError(f"holds {0 if vertex else 'no'} PLY vertices, expected at least 1")
    check_point_count(vertex.count)
    before = header.elements[: header.elements.index(vertex)]
    if any(element.has_lists for element in (*before, vertex)):
        raise InputError("the PLY file has lists before or in its vertices, expected numbers")
    names = [p.name for p in vertex.properties]
    missing = [axis for axis in "xyz" if axis not in names]
    if missing or len(set(names)) < len(names):
        raise InputError(f"the PLY vertices have {' '.join(names)}, expected x, y, z, once each")
    read = _read_text if header.form == "ascii" else _read_binary
    values, end = read(data, header, before, vertex)
    points = as_coordinates([values[axis] for axis in "xyz"])
    size = (header.grid.get("width", 0), header.grid.get("height", 1))
    return PointTable(points, _colours(values), *size), end


def _used_columns(vertex: PlyElement) -> dict[str, int]:
    used = {"x", "y", "z", *(name for names in COLOUR_NAMES for name in names)}
    return {p.name: i for i, p in enumerate(vertex.properties) if p.name in used}


def _read_text(
    data: bytes, header: PlyHeader, before: list[PlyElement], vertex: PlyElement
) -> tuple[dict[str, NDArray], int]:
    start = sum(element.count for element in before)
    columns = _used_columns(vertex)
    text = data[header.body_at :].decode("latin-1")
    table = parse_rows(text, vertex.count, list(columns.values()), skip=start)
    values: dict[str, NDArray] = dict(zip(columns, table.T, strict=True))
    for name in columns.keys() - set("xyz"):
        if vertex.properties[columns[name]].kind == "u1":
            values[name] = _colour_bytes(values[name], name)
    return values, start + vertex.count


def _read_binary(
    data: bytes, header: PlyHeader, before: list[PlyElement], vertex: PlyElement
) -> tuple[dict[str, NDArray], int]:
    order = header.byte_order
    start = header.body_at + sum(e.count * _record(e, order).itemsize for e in before)
    record = _record(vertex, order)
    end = start + vertex.count * record.itemsize
    if len(data) < end:
        raise InputError(
            f"the PLY file is truncated: {len(data)} bytes, expected {end} for "
            f"{vertex.count} vertices"
        )
    records = np.frombuffer(data, record, vertex.count, start)
    native = record.newbyteorder("=")
    columns = _used_columns(vertex)
    return {name: records[f"{i}"].astype(native[i]) for name, i in columns.items()}, end


def _record(element: PlyElement, order: str) -> np.dtype:
    # Fields are numbered, because only vertex properties must have unique names.
    return np.dtype([(f"{i}", order + p.kind) for i, p in enumerate(element.properties)])


def _colours(values: dict[str, NDArray]) -> NDArray[np.uint8] | None:
    for names in COLOUR_NAMES:
        if not all(name in values for name in names):
            continue
        colours = np.stack([values[name] for name in names], axis=-1)
        if colours.dtype == np.uint8:
            return colours
        if colours.dtype.kind == "f" and bool(((colours >= 0) & (colours <= 1)).all()):
            return np.rint(colours * 255).astype(np.uint8)
        raise InputError(f"the PLY colours are {colours.dtype}, expected uchar or float 0 to 1")
    return None


def _colour_bytes(values: NDArray[np.float64], name: str) -> NDArray[np.uint8]:
    if not ((values >= 0) & (values <= 255) & (values % 1 == 0)).all():
        raise InputError(f"the PLY property {name} holds values outside 0 to 255")
    return values.astype(np.uint8)


def _scatter(table: PointTable, cells: list[list[int]]) -> PointTable:
    """Assign the points to the pixels of a range grid: each cell lists no vertex or one."""
    if table.width * table.height != len(cells):
        raise InputError(
            f"the PLY range_grid has {len(cells)} cells, expected num_cols x num_rows = "
            f"{table.width} x {table.height}"
        )
    longest = max(map(len, cells), default=0)
    if longest > 1:
        raise InputError(f"a PLY range_grid cell has {longest} vertices, expected 0 or 1")
    filled = np.array([bool(cell) for cell in cells])
    vertices = np.array([cell[0] for cell in cells if cell], dtype=np.int64)
    points = np.full((len(cells), 3), np.nan, dtype=table.points.dtype)
    points[filled] = table.points[vertices]
    colours = None
    if table.colours is not None:
        colours = np.zeros((len(cells), 3), dtype=np.uint8)
        colours[filled] = table.colours[vertices]
    return PointTable(points, colours, table.width, table.height)


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

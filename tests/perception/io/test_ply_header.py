"""Tests of parsing PLY headers."""

from __future__ import annotations

import pytest

from eyehand.errors import InputError
from eyehand.perception.io.ply_header import PlyProperty, parse_ply_header

HEADER = b"""ply
format binary_big_endian 1.0
comment made by hand
comment width many
obj_info num_cols 640
obj_info num_rows 480
element vertex 12
property float x
property uchar red
element face 3
property list uchar int vertex_indices
property short flags
end_header
data"""


@pytest.mark.parametrize("line_end", [b"\n", b"\r\n"])
def test_elements_properties_and_grid_are_parsed(line_end: bytes) -> None:
    data = HEADER.replace(b"\n", line_end)
    header = parse_ply_header(data)
    assert data[header.body_at :] == b"data"
    assert (header.form, header.byte_order) == ("binary_big_endian", ">")
    assert header.grid == {"width": 640, "height": 480}
    vertex, face = header.elements
    assert (vertex.name, vertex.count, vertex.has_lists) == ("vertex", 12, False)
    assert vertex.properties == [PlyProperty("x", "f4"), PlyProperty("red", "u1")]
    assert (face.count, face.has_lists) == (3, True)
    assert face.properties == [
        PlyProperty("vertex_indices", "i4", "u1"),
        PlyProperty("flags", "i2"),
    ]
    assert header.element("edge") is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"ply\n", b"plx\n", r"not a PLY file: it begins with b'plx"),
        (b"end_header", b"end", "no end_header line"),
        (b"binary_big_endian", b"utf8", "format is 'utf8', expected one of"),
        (b"vertex 12", b"vertex 1e3", "has element vertex 1e3, expected a whole number"),
        (b"property float x", b"property half x", "has 'property half x', which is not PLY"),
        (b"list uchar", b"list float", "has 'property list float int vertex_indices', which"),
        (b"element vertex 12\n", b"", "has 'property float x', which is not PLY"),
    ],
)
def test_broken_headers_are_rejected(old: bytes, new: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_ply_header(HEADER.replace(old, new))

"""Encoding of triangle meshes as PLY, STL or OBJ files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MeshFormat = Literal["ply", "stl", "obj"]
"""File format. PLY and STL are binary with normals, OBJ is text."""

OBJ_HEADER = "eyehand fit, metres"


def mesh_bytes(vertices: NDArray[np.float64], faces: NDArray[np.int64], form: MeshFormat) -> bytes:
    """Encode a mesh as the bytes of a file.

    Parameters
    ----------
    vertices
        Positions (V, 3), m.
    faces
        Vertex indices (T, 3), counter-clockwise seen from outside.
    form
        File format.
    """
    import trimesh

    # process=False keeps the order of the vertices.
    surface = trimesh.Trimesh(vertices, faces, process=False)
    if form == "ply":
        encoded = surface.export(file_type="ply", vertex_normal=True)
    elif form == "stl":
        encoded = surface.export(file_type="stl")
    else:
        encoded = surface.export(file_type="obj", include_normals=True, header=OBJ_HEADER)
    return encoded if isinstance(encoded, bytes) else str(encoded).encode("ascii")

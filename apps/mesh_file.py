"""A triangle mesh as the bytes of a PLY, STL or OBJ file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MeshFormat = Literal["ply", "stl", "obj"]
"""PLY and STL are binary with normals, OBJ is text."""

OBJ_HEADER = "eyehand fit, metres"


def mesh_bytes(vertices: NDArray[np.float64], faces: NDArray[np.int64], form: MeshFormat) -> bytes:
    """Encode vertices (V, 3) in m and faces (T, 3), counter-clockwise seen from outside."""
    import trimesh

    # process=False keeps vertices as they are: merging them would lose nothing but our order.
    surface = trimesh.Trimesh(vertices, faces, process=False)
    if form == "ply":
        encoded = surface.export(file_type="ply", vertex_normal=True)
    elif form == "stl":
        encoded = surface.export(file_type="stl")
    else:
        encoded = surface.export(file_type="obj", include_normals=True, header=OBJ_HEADER)
    return encoded if isinstance(encoded, bytes) else str(encoded).encode("ascii")

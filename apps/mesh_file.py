"""Triangle meshes: joining, and encoding as PLY, STL or OBJ files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
    """Vertices (V, 3), m, and faces (T, 3), counter-clockwise seen from outside."""

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
    # These imports take a second.
    import trimesh
    from trimesh.exchange.obj import export_obj
    from trimesh.exchange.ply import export_ply
    from trimesh.exchange.stl import export_stl

    surface = trimesh.Trimesh(vertices, faces, process=False)
    if form == "stl":
        return export_stl(surface)
    if form == "ply":
        return export_ply(surface, vertex_normal=True)
    return str(export_obj(surface, include_normals=True, header=OBJ_HEADER)).encode()


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)

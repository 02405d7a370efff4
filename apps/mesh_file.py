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
STL_TEXT_BYTES = 80
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
PLY_FACE = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
"""Records of binary files. trimesh writes the same, but to load it takes 1.0 s of CPU."""


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
    if form == "stl":
        return _stl(vertices[faces])
    normals = _vertex_normals(vertices, faces)
    return _ply(vertices, faces, normals) if form == "ply" else _obj(vertices, faces, normals)


def join_meshes(meshes: Sequence[Mesh]) -> Mesh:
    """Return several meshes as one."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
    faces = [faces + start for (_, faces), start in zip(meshes, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)


def _stl(corners: NDArray[np.float64]) -> bytes:
    """Encode triangles (T, 3, 3) as binary STL."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    records = np.zeros(len(corners), STL_TRIANGLE)
    records["normal"] = _unit(normals)
    records["corners"] = corners
    return b"\0" * STL_TEXT_BYTES + np.array(len(corners), "<u4").tobytes() + records.tobytes()


def _ply(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], normals: NDArray[np.float64]
) -> bytes:
    """Encode a mesh as binary PLY."""
    names = ("x", "y", "z", "nx", "ny", "nz")
    properties = "\n".join(f"property float {name}" for name in names)
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.zeros(len(faces), PLY_FACE)
    records["count"], records["corners"] = 3, faces
    rows = np.hstack([vertices, normals]).astype("<f4")
    return header.encode("ascii") + rows.tobytes() + records.tobytes()


def _obj(
    vertices: NDArray[np.float64], faces: NDArray[np.int64], normals: NDArray[np.float64]
) -> bytes:
    """Encode a mesh as OBJ text."""
    lines = [f"# {OBJ_HEADER}"]
    lines += [f"v {x:.8f} {y:.8f} {z:.8f}" for x, y, z in vertices.tolist()]
    lines += [f"vn {x:.6f} {y:.6f} {z:.6f}" for x, y, z in normals.tolist()]
    lines += [f"f {a}//{a} {b}//{b} {c}//{c}" for a, b, c in (faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode("ascii")


def _vertex_normals(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return unit normals (V, 3): the mean over the faces, weighted by their areas."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weights = np.repeat(normals, 3, axis=0)
    sums = [np.bincount(faces.ravel(), weights[:, k], len(vertices)) for k in range(3)]
    return _unit(np.column_stack(sums).astype(np.float64))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.maximum(length, np.finfo(float).tiny)

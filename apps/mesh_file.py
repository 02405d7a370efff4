"""A triangle mesh as a binary PLY file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eyehand.perception.atomic_write import atomic_write
from eyehand.perception.open3d_import import import_open3d

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray


def write_mesh(path: Path, vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> None:
    """Write vertices (V, 3) in m and faces (T, 3) with vertex normals, at once or not at all."""
    o3d = import_open3d()
    surface = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(faces)
    )
    surface.compute_vertex_normals()
    with atomic_write(path) as temporary:
        o3d.io.write_triangle_mesh(str(temporary), surface)

"""Points spread evenly over the surface of a mesh file."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .input_file import naming, read_bytes
from .open3d_import import import_open3d
from .ply import read_ply_faces

if TYPE_CHECKING:
    from numpy.typing import NDArray

STL_HEADER_BYTES = 84
"""A binary STL's 80 bytes of text and the number of its triangles."""

STL_TRIANGLE_BYTES = 50
"""A binary STL's normal, three corners and attribute."""


def sample_surface(path: Path | str, samples: int, seed: int) -> NDArray[np.float64]:
    """Points drawn uniformly by area from an OBJ, STL or PLY mesh, the same for the same seed.

    A file of vertices without faces gives these. Polygons are taken to be convex.

    Parameters
    ----------
    path : Path or str
        The mesh, in metres. Its suffix chooses the format.
    samples : int
        How many points to draw.
    seed : int
        Seed of the generator that places them.

    Returns
    -------
    (samples, 3) float64
        Points, m.

    Raises
    ------
    InputError
        If `samples` is not positive, or the file is missing, damaged, or holds no surface.
    DeviceError
        If open3d, which reads STL, cannot be loaded.
    """
    if samples < 1:
        raise InputError(f"samples must be >= 1, got {samples}")
    path = Path(path)
    data = read_bytes(path)
    with naming(path):
        suffix = path.suffix.lower()
        if suffix == ".stl":
            vertices, triangles = _read_stl(path, data)
        else:
            vertices, faces = _parse_obj(data) if suffix == ".obj" else read_ply_faces(path)
            triangles = _fans(faces)
            if not len(triangles):
                return _finite(vertices)
        return sample_triangles(_finite(vertices), triangles, samples, np.random.default_rng(seed))


def sample_triangles(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    samples: int,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Draw points (samples, 3) uniformly by area from triangles (T, 3) over vertices (V, 3), m.

    Osada et al., Shape Distributions, ACM TOG 21(4), 2002, eq. (1).

    Raises
    ------
    InputError
        If a triangle names a vertex that is not there, or they have no finite area.
    """
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise InputError(
            f"the mesh's faces name vertices {triangles.min()} to {triangles.max()}, "
            f"expected 0 to {len(vertices) - 1}"
        )
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        ends = np.cumsum(areas)
    if not 0 < ends[-1] < np.inf:
        raise InputError(f"the mesh's surface measures {ends[-1]:g} m², expected a finite area > 0")
    # side="right" never picks a triangle without area, which ends where its forerunner does.
    picked = np.searchsorted(ends, rng.random(samples) * ends[-1], side="right")
    picked = np.minimum(picked, np.flatnonzero(areas)[-1])
    root, along = np.sqrt(rng.random(samples))[:, None], rng.random(samples)[:, None]
    return (1 - root) * a[picked] + root * (1 - along) * b[picked] + root * along * c[picked]


def _read_stl(path: Path, data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    open3d = import_open3d()
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        mesh = open3d.io.read_triangle_mesh(str(path))
    vertices = np.array(mesh.vertices, dtype=np.float64)
    triangles = np.array(mesh.triangles, dtype=np.int64)
    if not len(triangles):
        held = f"{len(data)} bytes"
        if not data.lstrip().startswith(b"solid"):
            count = int.from_bytes(data[80:STL_HEADER_BYTES], "little")
            held += (
                f", expected {STL_HEADER_BYTES + STL_TRIANGLE_BYTES * count} for the {count} "
                "triangles that a binary STL's header declares"
            )
        raise InputError(f"not a whole STL file with triangles ({held})")
    return vertices, triangles


def _finite(vertices: NDArray[np.floating]) -> NDArray[np.float64]:
    bad = int(np.count_nonzero(~np.isfinite(vertices).all(axis=1)))
    if bad:
        raise InputError(f"{bad} vertices are NaN or infinite, expected finite metres")
    return vertices.astype(np.float64)


def _fans(faces: list[list[int]]) -> NDArray[np.int64]:
    """Triangles (N, 3) that cover convex polygons: the first corner with each further edge."""
    short = next((face for face in faces if len(face) < 3), None)
    if short is not None:
        raise InputError(f"a face has {len(short)} corners, expected at least 3")
    triangles = [(face[0], *pair) for face in faces for pair in pairwise(face[1:])]
    return np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _parse_obj(data: bytes) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Vertices of a Wavefront OBJ, and the corners of each face by number of vertex from 0.

    Not by open3d: its 0.20 readers drop files with four-cornered faces, or crash on files that
    are not OBJ.
    """
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(data.decode("latin-1").splitlines(), start=1):
        kind, *words = line.split() or [""]
        try:
            if kind == "v":
                x, y, z = (float(word) for word in words[:3])
                vertices.append([x, y, z])
            elif kind == "f":
                faces.append([_corner(word, len(vertices)) for word in words])
        except ValueError as error:
            raise InputError(
                f"line {number} is {line[:40]!r} ({error}), expected `v x y z` or `f i j k …`"
            ) from error
    if not vertices:
        raise InputError("not an OBJ file: it has no vertex, expected lines `v x y z`")
    return np.array(vertices), faces


def _corner(word: str, count: int) -> int:
    """Index from 0 of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative counts from the end."""
    index = int(word.partition("/")[0])
    from_zero = index - 1 if index > 0 else count + index
    if index == 0 or from_zero < 0:
        raise ValueError(f"there is no vertex {index}")
    return from_zero

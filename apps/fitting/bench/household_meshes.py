"""Meshes of real household objects: files, class, half, and the inside of the surface."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.stats import qmc

from eyehand.errors import InputError
from eyehand.perception.io import read_mesh, sample_triangles

from ...open3d_import import import_open3d
from .compound_solids import ray_scene
from .mesh_classes import Half, MeshClass, class_of, half_of, plain_name

SUFFIXES = (".obj", ".stl", ".ply")
COLLISION = "_collision"
"""Ending of simplified meshes for physics, which no camera sees."""
CLASS_FILE = "classes.csv"
"""Optional file of a folder with the columns name and class."""
VOLUME_SAMPLES_LOG2 = 15
"""Binary logarithm of the number of points in the bounds of a mesh. A volume of a tenth of the
bounds is accurate to 1 %."""
PARITY_RAYS = 9
"""Rays of random directions per point. Most of them decide whether it lies inside, so that holes in
a scan do no harm."""
SURFACE_SAMPLES = 2000
"""Points on the surface of a mesh."""
MAX_SIZE = 0.6
"""Maximum size of an object, m. A larger mesh is probably in mm."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class HouseholdMesh:
    """The mesh of one object."""

    name: str
    """Name of the object, without the file's numbers of triangles and suffixes."""
    folder: str
    """Name of the folder of the file."""
    kind: MeshClass
    """Class of the object."""
    half: Half
    """Half of the data that the object belongs to."""
    vertices: NDArray[np.float64]
    """(V, 3), m, z up, in the frame of the file."""
    faces: NDArray[np.int64]
    """(T, 3)."""

    @property
    def key(self) -> str:
        """Folder and name, which are unique."""
        return f"{self.folder}/{self.name}"

    @cached_property
    def hull_vertices(self) -> NDArray[np.float64]:
        """Vertices (K, 3) of the convex hull, m."""
        return self.vertices[ConvexHull(self.vertices).vertices]

    @cached_property
    def hull_equations(self) -> NDArray[np.float64]:
        """Outward unit normals and offsets (F, 4) of the convex hull."""
        return np.unique(ConvexHull(self.vertices).equations.round(9), axis=0)

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest coordinates, (3,) each, m."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @cached_property
    def samples(self) -> NDArray[np.float64]:
        """Points (S, 3) spread evenly in the bounds, m."""
        low, high = self.bounds
        sobol = qmc.Sobol(3, rng=np.random.default_rng(0))
        return low + (high - low) * sobol.random_base2(VOLUME_SAMPLES_LOG2)

    @cached_property
    def sample_volume(self) -> float:
        """Volume for which a sample stands, m³."""
        low, high = self.bounds
        return float(np.prod(high - low)) / len(self.samples)

    @cached_property
    def in_material(self) -> NDArray[np.bool_]:
        """Whether each sample lies in the material, (S,)."""
        return self.contains(self.samples)

    @cached_property
    def in_hull(self) -> NDArray[np.bool_]:
        """Whether each sample lies in the convex hull, (S,)."""
        return self.hull_contains(self.samples)

    def contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether points (N, 3) in the frame of the mesh lie in the material, (N,)."""
        middle = self.vertices.mean(axis=0)
        scene = ray_scene(self.vertices, self.faces, middle)
        query = import_open3d().core.Tensor((points - middle).astype(np.float32))
        return scene.compute_occupancy(query, nthreads=1, nsamples=PARITY_RAYS).numpy() > 0.5

    def hull_contains(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return whether points (N, 3) in the frame of the mesh lie in the convex hull, (N,)."""
        inside = np.ones(len(points), dtype=bool)
        for *normal, offset in self.hull_equations:
            inside &= points @ normal + offset <= 0
        return inside

    @cached_property
    def surface_points(self) -> NDArray[np.float64]:
        """Points (N, 3) of the surface, m."""
        return sample_triangles(
            self.vertices, self.faces, SURFACE_SAMPLES, np.random.default_rng(0)
        )

    def distances(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distances (N,) of points (N, 3) in the frame of the mesh to the surface, m."""
        middle = self.vertices.mean(axis=0)
        query = import_open3d().core.Tensor((points - middle).astype(np.float32))
        scene = ray_scene(self.vertices, self.faces, middle)
        return scene.compute_distance(query, nthreads=1).numpy().astype(np.float64)


def read_household(
    folders: Iterable[Path | str], half: Half | None = None
) -> tuple[HouseholdMesh, ...]:
    """Read the meshes of folders in the order of their names, without subfolders.

    Parameters
    ----------
    folders
        Folders with OBJ, STL or PLY files in m. An optional classes.csv declares the classes.
    half
        The half to keep. Default: both.

    Raises
    ------
    InputError
        If a folder is missing or has no mesh, or a mesh is damaged, has no triangles or is larger
        than 0.6 m.
    """
    found = [mesh for folder in folders for mesh in _read_folder(Path(folder))]
    return tuple(mesh for mesh in found if half is None or mesh.half == half)


def _read_folder(folder: Path) -> list[HouseholdMesh]:
    if not folder.is_dir():
        raise InputError(f"there is no folder {folder}; give a folder of mesh files")
    files = sorted(
        path
        for path in folder.iterdir()
        if path.suffix.lower() in SUFFIXES and not path.stem.endswith(COLLISION)
    )
    if not files:
        raise InputError(f"{folder} contains no mesh, expected {', '.join(SUFFIXES)} files")
    declared = _declared_classes(folder / CLASS_FILE)
    return [_read_one(path, declared) for path in files]


def _declared_classes(path: Path) -> dict[str, str]:
    if not path.is_file():
        return {}
    with path.open(newline="", encoding="utf-8") as file:
        rows: list[dict[str, Any]] = list(csv.DictReader(file))
    if any("name" not in row or "class" not in row for row in rows):
        raise InputError(f"{path} must have the columns name and class")
    return {row["name"]: row["class"] for row in rows}


def _read_one(path: Path, declared: dict[str, str]) -> HouseholdMesh:
    vertices, faces = read_mesh(path)
    if not len(faces):
        raise InputError(f"{path} has no triangles, expected a surface")
    size = float(np.ptp(vertices, axis=0).max())
    if size > MAX_SIZE:
        raise InputError(f"{path} measures {size:g} m, expected at most {MAX_SIZE:g} m")
    name = plain_name(path.stem)
    kind = class_of(name, declared.get(path.stem))
    return HouseholdMesh(name, path.parent.name, kind, half_of(name), vertices, faces)

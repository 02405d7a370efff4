"""Reading and writing of point clouds of single objects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from eyehand.errors import InputError

from .atomic_write import atomic_write
from .input_file import naming, read_bytes
from .mesh import sample_surface
from .npz import read_arrays
from .pcd import pcd_bytes, read_pcd
from .ply import ply_bytes, read_ply
from .ply_header import parse_ply_header
from .point_table import PointTable
from .text_points import parse_text_points, points_text

CLOUD_SUFFIXES = (".ply", ".pcd", ".npz", ".xyz", ".txt", ".csv", ".obj", ".stl")
"""File formats of `read_cloud`."""

WRITTEN_SUFFIXES = (".ply", ".pcd", ".npz", ".xyz")
"""File formats of `write_cloud`."""

MAX_COORDINATE_M = 1e9
"""Maximum absolute coordinate, m. Earth-centred coordinates are below 1e7; products of larger ones
leave the range of numbers."""

DEFAULT_SAMPLES = 10_000
"""Points sampled from a surface. On a 10 cm box their mean spacing is 2 mm."""


def read_cloud(
    path: Path | str, *, samples: int = DEFAULT_SAMPLES, seed: int = 0
) -> NDArray[np.float64]:
    """Read the points of a cloud or surface file. Points with NaN or infinity are dropped.

    PLY, PCD, NPZ (array `points`), and text (XYZ, TXT, CSV: x, y, z first, or columns so named)
    give their points. OBJ, STL and PLY files with faces are surfaces. Their points are drawn
    uniformly by area. The same `seed` gives the same points.

    Parameters
    ----------
    path : Path or str
        The file, in metres; its suffix chooses the format.
    samples : int
        Points to draw from a surface.
    seed : int
        Seed of that draw.

    Returns
    -------
    (N, 3) float64
        Points in the file's frame, m, in its order; N >= 1.

    Raises
    ------
    InputError
        If the file is missing, damaged, of an unknown format, or holds no finite point, or a
        coordinate is larger than `MAX_COORDINATE_M`.
    """
    path = Path(path)
    suffix = _checked_suffix(path, CLOUD_SUFFIXES)
    if suffix in (".obj", ".stl") or (suffix == ".ply" and _has_faces(path)):
        points = sample_surface(path, samples, seed)
    elif suffix in (".ply", ".pcd"):
        points = (read_ply(path) if suffix == ".ply" else read_pcd(path)).points
    elif suffix == ".npz":
        points = read_arrays(path, ("points",))["points"]
    else:
        data = read_bytes(path)
        with naming(path):
            points = parse_text_points(data)
    with naming(path):
        if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
            raise InputError(f"points are {points.shape} {points.dtype}, expected (N, 3) float")
        finite = points[np.isfinite(points).all(axis=1)].astype(np.float64)
        if not len(finite):
            raise InputError(f"none of its {len(points)} points is finite, expected at least 1")
        farthest = float(np.abs(finite).max())
        if farthest > MAX_COORDINATE_M:
            raise InputError(
                f"a coordinate is {farthest:.3g} m, expected at most {MAX_COORDINATE_M:.0e} m"
            )
        return finite


def is_organised_cloud(path: Path | str) -> bool:
    """Return whether a PCD or PLY file holds one point per pixel of a depth image.

    Files of other formats, and PLY files with faces, do not.

    Raises
    ------
    InputError
        If the PCD or PLY file is missing or damaged.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == ".pcd":
        return read_pcd(path).height > 1
    return suffix == ".ply" and not _has_faces(path) and read_ply(path).height > 1


def write_cloud(
    path: Path | str, points: ArrayLike, colours: NDArray[np.uint8] | None = None
) -> Path:
    """Write points. NPZ and XYZ keep float64, PLY and PCD store float32.

    Parameters
    ----------
    path : Path or str
        The file, replaced if it exists; its suffix (.ply, .pcd, .npz, .xyz) chooses the format.
    points : (N, 3) array
        Points, m.
    colours : (N, 3) uint8, optional
        RGB colours.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        If the suffix is unknown, the folder is missing, or an array has another shape, type or
        holds NaN.
    DeviceError
        If the system fails to write.
    """
    path = Path(path)
    suffix = _checked_suffix(path, WRITTEN_SUFFIXES)
    with naming(path):
        table = _checked_table(points, colours)
        with atomic_write(path) as target:
            if suffix == ".npz":
                arrays: dict[str, NDArray] = {"points": table.points}
                if table.colours is not None:
                    arrays["colours"] = table.colours
                np.savez_compressed(target, allow_pickle=False, **arrays)
            elif suffix == ".xyz":
                target.write_text(points_text(table.points, table.colours), encoding="ascii")
            else:
                target.write_bytes((ply_bytes if suffix == ".ply" else pcd_bytes)(table))
    return path


def _checked_suffix(path: Path, known: tuple[str, ...]) -> str:
    suffix = path.suffix.lower()
    if suffix not in known:
        raise InputError(
            f"{path}: suffix {path.suffix!r} is no cloud format, expected one of {', '.join(known)}"
        )
    return suffix


def _has_faces(path: Path) -> bool:
    data = read_bytes(path)
    with naming(path):
        faces = parse_ply_header(data).element("face")
    return faces is not None and faces.count > 0


def _checked_table(points: ArrayLike, colours: NDArray[np.uint8] | None) -> PointTable:
    points = np.asarray(points)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise InputError(f"points are {points.shape} {points.dtype}, expected (N, 3) float")
    bad = int(np.count_nonzero(~np.isfinite(points).all(axis=1)))
    if bad or not len(points):
        raise InputError(
            f"{bad} of {len(points)} points are NaN or infinite, expected at least 1 point, "
            "all finite"
        )
    if colours is not None:
        colours = np.asarray(colours)
        if colours.shape != points.shape or colours.dtype != np.uint8:
            raise InputError(
                f"colours are {colours.shape} {colours.dtype}, expected {points.shape} uint8 RGB"
            )
    return PointTable(points.astype(np.float64), colours)

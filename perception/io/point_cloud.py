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
from .point_table import PointTable, load_numbers

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
            " (.npz with `points`)"
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


COMMENTS = ("#", "//")
"""Prefixes of comment lines."""

AXES = ("x", "y", "z")
"""Columns that a header line must name."""

FIRST_COLUMNS = [0, 1, 2]
"""Columns of x, y, z in a file without a header line."""


def parse_text_points(data: bytes) -> NDArray[np.float64]:
    """Parse a text table with one point per line, (N, 3) float64. Further columns are skipped.

    Numbers are separated by white space, commas or semicolons. A first line of words names the
    columns, x, y and z among them.

    Raises
    ------
    InputError
        If the data are not text, hold no point, use decimal commas, or a line lacks a number.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"not a text file (byte {error.start}), expected x y z a line") from error
    lines = [line for line in map(str.strip, text.splitlines()) if line]
    lines = [line for line in lines if not line.startswith(COMMENTS)]
    if not lines:
        raise InputError("holds no points, expected x y z a line")
    if ";" in lines[-1] and "," in lines[-1]:
        raise InputError(f"holds decimal commas ({lines[-1][:40]!r}), expected decimal points")
    rows = [line.replace(",", " ").replace(";", " ") for line in lines]
    columns = FIRST_COLUMNS
    if not _is_number(rows[0].split()[:1]):
        columns = _named_columns(rows[0])
        rows = rows[1:]
    if not rows:
        raise InputError("holds a header and no points, expected x y z a line")
    return load_numbers("\n".join(rows), columns)


def points_text(points: NDArray[np.floating], colours: NDArray[np.uint8] | None) -> str:
    """Format lines `x y z` or `x y z r g b`, with the shortest numbers that read back exactly."""
    rows = points.tolist()
    if colours is not None:
        rows = [row + colour for row, colour in zip(rows, colours.tolist(), strict=True)]
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows)


def _named_columns(header: str) -> list[int]:
    names = [name.strip("\"'").lower() for name in header.split()]
    if any(names.count(axis) != 1 for axis in AXES):
        raise InputError(f"first line is {header[:60]!r}, expected numbers or the names x, y, z")
    return [names.index(axis) for axis in AXES]


def _is_number(words: list[str]) -> bool:
    try:
        float(words[0])
    except (ValueError, IndexError):
        return False
    return True

"""Read objects for the simulated world from a folder of mesh or URDF files, and check them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.errors import InputError
from eyehand.perception.io import read_mesh

from .convex_pieces import convex_pieces, hull_volume

MESH_SUFFIXES = (".obj", ".stl")
URDF_SUFFIX = ".urdf"

DENSITY = 400.0
"""Default mass over volume if a file has no mass, kg/m³: between half-empty cartons and fruit."""
MIN_LENGTH_M, MAX_LENGTH_M = 0.01, 0.6
"""Limits of the longest side of an object's bounding box."""
MIN_THICKNESS_M = 1e-3
"""Minimum extent of an object: a thinner mesh is a surface, not a solid."""
MM = 1e-3
"""Scale from mm to m. A mesh that is far too large is usually in mm."""
MIN_MASS_KG, MAX_MASS_KG = 1e-3, 20.0
"""Limits of an object's mass."""


@dataclass(frozen=True)
class FolderObject:
    """One rigid object from a file.

    Its frame has the axes of the file. Its origin is the centre of mass of the convex hull. The
    camera sees the mesh itself. Contacts use its convex pieces, or the hull of the mesh.
    """

    name: str
    """Path of the file in the folder, without suffix, joined by underscores."""
    vertices: NDArray[np.float64]
    """Vertices of the mesh, (V, 3), m."""
    faces: NDArray[np.int64]
    """Triangles, (T, 3), with the winding of the file."""
    mass: float
    """Mass, kg."""
    file: Path
    """Source file."""
    pieces: tuple[NDArray[np.float64], ...] = ()
    """Vertices of each convex piece of the collision mesh, (P, 3), m. Empty if the mesh does not
    consist of convex solids."""


def read_objects(folder: Path | str, density: float | None = None) -> tuple[FolderObject, ...]:
    """Read all objects of a folder and its subfolders, in the order of their paths.

    If there are URDF files, each is an object with one rigid link, and mesh files are read only
    through them. Otherwise each mesh file is an object. The mass is that of the URDF, or density
    times volume. The volume is that of the convex pieces, or of the mesh if it is closed, otherwise
    that of its convex hull.

    Parameters
    ----------
    folder
        Folder with .urdf, .obj or .stl files, lengths in m.
    density
        Mass over volume of all objects, kg/m³, > 0. None uses the mass of the file, and `DENSITY`
        for objects without one. Files of scaled meshes often keep the mass of the original size.

    Raises
    ------
    InputError
        If the folder is missing or contains no object, or a file cannot be read, is not a solid,
        or has a size or mass outside the limits. The message names the file.
    """
    folder = Path(folder)
    if density is not None and not 0 < density < np.inf:
        raise InputError(f"density must be > 0 kg/m³, got {density}")
    if not folder.is_dir():
        raise InputError(f"there is no folder {folder}; give a folder of mesh or URDF files")
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    urdfs = [path for path in files if path.suffix.lower() == URDF_SUFFIX]
    meshes = [path for path in files if path.suffix.lower() in MESH_SUFFIXES]
    if not (urdfs or meshes):
        raise InputError(f"{folder} contains no objects, expected .urdf, .obj or .stl files")
    found = []
    for path in urdfs or meshes:
        surface, mass = _read_urdf(path) if urdfs else (_read_mesh(path), None)
        name = "_".join(path.relative_to(folder).with_suffix("").parts)
        found.append(_checked(name, path, surface, mass, density))
    names = [item.name for item in found]
    for item in found:
        if names.count(item.name) > 1:
            raise InputError(f"{item.file}: another file has the same object name, {item.name}")
    return tuple(found)


def _checked(
    name: str, file: Path, surface: Any, mass: float | None, density: float | None
) -> FolderObject:
    """Check a trimesh surface and move its origin to the hull's centre of mass."""
    # Pieces that touch have equal corners. Merging these would join them.
    pieces = convex_pieces(np.asarray(surface.vertices), np.asarray(surface.faces))
    # It closes the surface of a file that repeats the corners of each triangle.
    surface.merge_vertices()
    vertices = np.asarray(surface.vertices, dtype=np.float64)
    faces = np.asarray(surface.faces, dtype=np.int64)
    if len(faces) == 0:
        raise InputError(f"{file} has no triangles")
    if not np.isfinite(vertices).all():
        raise InputError(f"{file} has vertices that are not finite")
    extents = np.ptp(vertices[np.unique(faces)], axis=0)
    longest = float(extents.max())
    if longest > MAX_LENGTH_M:
        likely = MIN_LENGTH_M <= longest * MM <= MAX_LENGTH_M
        hint = ": it seems to be in mm, scale it by 0.001" if likely else ""
        raise InputError(f"{file} is {longest:g} m long, expected at most {MAX_LENGTH_M:g} m{hint}")
    if longest < MIN_LENGTH_M:
        raise InputError(f"{file} is {longest:g} m long, expected at least {MIN_LENGTH_M:g} m")
    if extents.min() < MIN_THICKNESS_M:
        raise InputError(
            f"{file} is {extents.min():g} m thick, expected at least {MIN_THICKNESS_M:g} m"
        )
    try:
        hull = surface.convex_hull
    except Exception as error:  # Qhull raises its own errors for flat, tilted meshes.
        raise InputError(f"{file} has no volume, expected a solid") from error
    pieces = pieces or convex_pieces(vertices, faces)
    volume = float(surface.volume) if surface.is_volume else float(hull.volume)
    if len(pieces) > 1:
        volume = sum(map(hull_volume, pieces))
    if mass is None or density is not None:
        mass = (density or DENSITY) * volume
    if not MIN_MASS_KG <= mass <= MAX_MASS_KG:
        raise InputError(
            f"{file} has a mass of {mass:g} kg, expected {MIN_MASS_KG:g} to {MAX_MASS_KG:g} kg"
        )
    centre = hull.center_mass
    moved = tuple(piece - centre for piece in pieces)
    return FolderObject(name, vertices - centre, faces, float(mass), file, moved)


def _read_mesh(path: Path) -> Any:
    """Read a file as one trimesh surface."""
    import trimesh

    return trimesh.Trimesh(*read_mesh(path), process=False)


def _read_urdf(path: Path) -> tuple[Any, float | None]:
    """Read the surface in the frame of the only link, and its mass; None if the file has none."""
    import trimesh

    try:
        robot = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError) as error:
        raise InputError(f"cannot read a URDF from {path}: {error}") from error
    links = robot.findall("link")
    if robot.tag != "robot" or len(links) != 1:
        raise InputError(f"{path} has {len(links)} links, expected a URDF of one rigid link")
    parts = links[0].findall("collision") or links[0].findall("visual")
    if not parts:
        raise InputError(f"{path}: the link has neither collision nor visual geometry")
    surface = trimesh.util.concatenate([_urdf_part(path, part) for part in parts])
    mass = links[0].find("inertial/mass")
    value = None if mass is None else _numbers(path, mass, "value", 1)[0]
    # Many URDF files contain a mass of 0 as a placeholder.
    return surface, value or None


def _urdf_part(path: Path, part: ElementTree.Element) -> Any:
    """Read one geometry of a link as a trimesh surface in the link's frame."""
    import trimesh

    shape = next(iter(part.find("geometry") or ()), None)
    if shape is None:
        raise InputError(f"{path}: a geometry is empty")
    if shape.tag == "box":
        surface = trimesh.creation.box(_numbers(path, shape, "size", 3))
    elif shape.tag == "sphere":
        surface = trimesh.creation.icosphere(radius=_numbers(path, shape, "radius", 1)[0])
    elif shape.tag == "cylinder":
        radius, length = (_numbers(path, shape, name, 1)[0] for name in ("radius", "length"))
        surface = trimesh.creation.cylinder(radius, length, sections=64)
    elif shape.tag == "mesh":
        surface = _read_mesh(_mesh_file(path, shape.get("filename", "")))
        surface.apply_scale(_numbers(path, shape, "scale", 3, "1 1 1"))
    else:
        raise InputError(
            f"{path}: a geometry is {shape.tag!r}, expected box, sphere, cylinder or mesh"
        )
    origin = part.find("origin")
    if origin is not None:
        T_link_part = np.eye(4)
        rotation = Rotation.from_euler("xyz", _numbers(path, origin, "rpy", 3, "0 0 0"))
        T_link_part[:3, :3] = rotation.as_matrix()
        T_link_part[:3, 3] = _numbers(path, origin, "xyz", 3, "0 0 0")
        surface.apply_transform(T_link_part)
    return surface


def _mesh_file(urdf: Path, name: str) -> Path:
    """Find a mesh file by its path relative to the URDF's folder or two folders above.

    Paths such as ``package://name/mesh.obj`` are tried with and without the package's name.
    """
    relative = name.partition("://")[2] if "://" in name else name
    endings = [Path(relative), Path(*Path(relative).parts[1:])]
    for folder in (urdf.parent, *urdf.resolve().parents[1:3]):
        for ending in endings:
            if ending.name and (folder / ending).is_file():
                return folder / ending
    raise InputError(f"{urdf} refers to a mesh {name!r} that does not exist")


def _numbers(
    path: Path, element: ElementTree.Element, name: str, count: int, default: str = ""
) -> list[float]:
    """Read an attribute with `count` finite numbers."""
    text = element.get(name, default)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(f"{path}: {element.tag} {name}={text!r}, expected {count} finite numbers")
    return values


Item = TypeVar("Item")
Split = Literal["all", "development", "held-out"]
"""Which objects of a folder are drawn. Settings are chosen on the development half only."""

IN_BOTH_FOLDERS: dict[str, Split] = {"mug": "held-out", "pepto_bismol": "development"}
"""Half of the names that both folders of the clutter-removal benchmark contain. Alternation would
put the two meshes of a name into different halves. The whole list is in docs/household_objects.md.
"""


def half_of(names: Sequence[str]) -> dict[str, Split]:
    """Return the half of each name: every other one in the order of the names.

    Names of `IN_BOTH_FOLDERS` keep their half in every folder.
    """
    halves: tuple[Split, Split] = ("development", "held-out")
    return {
        name: IN_BOTH_FOLDERS.get(name, halves[number % 2])
        for number, name in enumerate(sorted(set(names)))
    }


def select_half(items: Sequence[Item], names: Sequence[str], split: Split) -> tuple[Item, ...]:
    """Return the items of a half.

    Parameters
    ----------
    items
        Objects of a folder.
    names
        Name of each item: the name of its file without suffix.
    split
        The half, or "all".

    Raises
    ------
    InputError
        If the half is empty.
    """
    halves = half_of(names)
    chosen = tuple(
        item
        for item, name in zip(items, names, strict=True)
        if split == "all" or halves[name] == split
    )
    if not chosen:
        raise InputError(f"{len(items)} objects are too few for two halves: none is {split}")
    return chosen

"""Objects for the simulated world from a folder of meshes or URDFs, checked before use."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.errors import InputError
from eyehand.perception.io import read_mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

MESH_SUFFIXES = (".obj", ".stl")
URDF_SUFFIX = ".urdf"

DENSITY = 400.0
"""Mass over volume where a file tells no mass, kg/m³: between cartons with air in them and
fruit."""
SMALLEST, LARGEST = 0.01, 0.6
"""Longest side of the bounds that an object on a table may have, m."""
FLATTEST = 1e-3
"""Shortest side, m: thinner is a drawing, no solid."""
MM = 1e-3
"""A mesh that is far too large is most often in mm."""
LIGHTEST, HEAVIEST = 1e-3, 20.0
"""kg."""


@dataclass(frozen=True)
class FolderObject:
    """One rigid object.

    Its frame has the file's axes, and its origin at the centre of the convex hull: the physics
    collides with that hull, the camera sees the surface itself.
    """

    name: str
    """Its file's path in the folder without suffix, as one word."""
    vertices: NDArray[np.float64]
    """Corners of the surface, (V, 3), m."""
    faces: NDArray[np.int64]
    """Triangles, (T, 3), as the file turns them."""
    mass: float
    """kg."""
    file: Path
    """Where it came from."""


def read_objects(folder: Path | str, density: float = DENSITY) -> tuple[FolderObject, ...]:
    """Read all objects of a folder and the folders in it, in the order of their paths.

    Where there are URDFs, each is an object, of its one rigid link, and meshes are what they refer
    to; otherwise each mesh is one. The mass is the URDF's, or density times volume: that of the
    mesh where it is closed, else that of its convex hull.

    Parameters
    ----------
    folder
        With .urdf, .obj or .stl files, lengths in m.
    density
        kg/m³, > 0.

    Raises
    ------
    InputError
        If the folder is missing or holds none, or a file cannot be read, is no solid, or has an
        unlikely size or mass; the message names the file.
    """
    folder = Path(folder)
    if not 0 < density < np.inf:
        raise InputError(f"density must be > 0 kg/m³, got {density}")
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder of meshes or URDFs")
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    urdfs = [path for path in files if path.suffix.lower() == URDF_SUFFIX]
    meshes = [path for path in files if path.suffix.lower() in MESH_SUFFIXES]
    if not (urdfs or meshes):
        raise InputError(f"{folder} holds no objects: expected .urdf, .obj or .stl files")
    found = []
    for path in urdfs or meshes:
        surface, mass = _read_urdf(path) if urdfs else (_read_mesh(path), None)
        name = "_".join(path.relative_to(folder).with_suffix("").parts)
        found.append(_checked(name, path, surface, mass, density))
    names = [item.name for item in found]
    for item in found:
        if names.count(item.name) > 1:
            raise InputError(f"{item.file}: another file gives an object of the name {item.name}")
    return tuple(found)


def _checked(
    name: str, file: Path, surface: Any, mass: float | None, density: float
) -> FolderObject:
    """Check a trimesh surface and place it."""
    vertices = np.asarray(surface.vertices, dtype=np.float64)
    faces = np.asarray(surface.faces, dtype=np.int64)
    if len(faces) == 0:
        raise InputError(f"{file} has no triangles")
    if not np.isfinite(vertices).all():
        raise InputError(f"{file} has corners that are not finite")
    extents = np.ptp(vertices[np.unique(faces)], axis=0)
    longest = float(extents.max())
    if longest > LARGEST:
        likely = SMALLEST <= longest * MM <= LARGEST
        hint = ": it seems to be in mm, scale it by 0.001" if likely else ""
        raise InputError(f"{file} is {longest:g} m long, expected at most {LARGEST:g} m{hint}")
    if longest < SMALLEST:
        raise InputError(f"{file} is {longest:g} m long, expected at least {SMALLEST:g} m")
    if extents.min() < FLATTEST:
        raise InputError(
            f"{file} is {extents.min():g} m thin, expected a solid of {FLATTEST:g} m at least"
        )
    try:
        hull = surface.convex_hull
    except Exception as error:  # Qhull has errors of its own for flat things that lie askew.
        raise InputError(f"{file} has no volume, expected a solid") from error
    volume = float(surface.volume) if surface.is_volume else float(hull.volume)
    if mass is None:
        mass = density * volume
    if not LIGHTEST <= mass <= HEAVIEST:
        raise InputError(
            f"{file} has a mass of {mass:g} kg, expected {LIGHTEST:g} to {HEAVIEST:g} kg"
        )
    return FolderObject(name, vertices - hull.center_mass, faces, float(mass), file)


def _read_mesh(path: Path) -> Any:
    """Read a file as one trimesh surface."""
    import trimesh

    # trimesh merges equal corners of neighbouring triangles, which closes the surface.
    return trimesh.Trimesh(*read_mesh(path))


def _read_urdf(path: Path) -> tuple[Any, float | None]:
    """Surface in the frame of the one link, and its mass if it is told."""
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
        raise InputError(f"{path}: its link has neither collision nor visual geometry")
    surface = trimesh.util.concatenate([_urdf_part(path, part) for part in parts])
    mass = links[0].find("inertial/mass")
    told = None if mass is None else _numbers(path, mass, "value", 1)[0]
    # Many URDFs leave the mass at a placeholder.
    return surface, told or None


def _urdf_part(path: Path, part: ElementTree.Element) -> Any:
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
            f"{path}: a geometry is a {shape.tag}, expected box, sphere, cylinder, mesh"
        )
    origin = part.find("origin")
    if origin is not None:
        place = np.eye(4)
        turn = Rotation.from_euler("xyz", _numbers(path, origin, "rpy", 3, "0 0 0"))
        place[:3, :3] = turn.as_matrix()
        place[:3, 3] = _numbers(path, origin, "xyz", 3, "0 0 0")
        surface.apply_transform(place)
    return surface


def _mesh_file(urdf: Path, name: str) -> Path:
    """Find a mesh beside its URDF, or where a package's path leads from there or above."""
    relative = name.partition("://")[2] if "://" in name else name
    tails = [Path(relative), Path(*Path(relative).parts[1:])]
    for folder in (urdf.parent, *urdf.resolve().parents[1:3]):
        for tail in tails:
            if tail.name and (folder / tail).is_file():
                return folder / tail
    raise InputError(f"{urdf} refers to a mesh {name!r} that is not there")


def _numbers(
    path: Path, element: ElementTree.Element, name: str, count: int, usual: str = ""
) -> list[float]:
    text = element.get(name, usual)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise InputError(f"{path}: {element.tag} {name}={text!r}, expected {count} finite numbers")
    return values

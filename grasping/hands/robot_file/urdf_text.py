"""Prepare a URDF for MuJoCo: mesh files, links without collision shapes, and loops."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlparse
from xml.etree import ElementTree

import numpy as np

from eyehand.errors import InputError

from .mesh_bytes import mesh_bytes

COMPILER = {
    "discardvisual": "false",
    "strippath": "false",
    "fusestatic": "false",
    "boundmass": "1e-6",
    "boundinertia": "1e-9",
    "balanceinertia": "true",
}
"""Options of MuJoCo's compiler. Shapes for display stay, because a link can have no others."""

MAX_TURN, FULL_TURN, DEGREES = 12.6, 360.0, 5.0
"""Limits of a hinge in this range that are whole multiples of 5 are in degrees, not in rad. Robots
turn by two turns at most; the motors of geared joints turn further."""


@dataclass(frozen=True)
class Urdf:
    """A URDF that MuJoCo reads without a file system."""

    text: str
    """The XML text."""
    meshes: dict[str, bytes]
    """Contents of the mesh files by their names in the text."""
    sources: dict[str, str]
    """Path of each of them in the original file, for messages."""


def prepared_urdf(
    path: Path, root: ElementTree.Element, package_dirs: Sequence[Path | str]
) -> Urdf:
    """Return a URDF with its meshes, and without shapes for display beside collision shapes.

    Raises
    ------
    InputError
        If a mesh is missing, the links form a loop, or the file is a xacro.
    """
    if any(
        "xacro" in str(element.tag) or "${" in "".join(element.attrib.values())
        for element in root.iter()
    ):
        raise InputError(f"{path} is a xacro file; expand it first: xacro {path.name} > robot.urdf")
    _check_tree(path, root)
    for joint in root.findall("joint[@type='revolute']"):
        for limit in joint.iter("limit"):
            turns = [turn for turn in map(limit.get, ("lower", "upper")) if turn]
            if _in_degrees(path, turns):
                raise InputError(
                    f"{path}: joint {joint.get('name')!r} turns from {turns[0]} to {turns[-1]} "
                    "rad: write the limits of revolute joints in rad, not in degrees (limits that "
                    "are in rad must be no multiples of 5)"
                )
    folders = [Path(folder) for folder in package_dirs]
    listed = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    folders += [Path(folder) for folder in listed if folder]
    found: dict[str, str] = {}
    meshes: dict[str, bytes] = {}
    for link in root.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None and not _is_possible(inertial):
            # MuJoCo refuses it. The shapes have an inertia, too.
            link.remove(inertial)
        if link.find("collision") is not None:
            for visual in link.findall("visual"):
                link.remove(visual)
        for mesh in link.iter("mesh"):
            given = mesh.get("filename", "")
            if given not in found:
                file = _mesh_file(path, str(link.get("name")), given, folders)
                suffix, content = mesh_bytes(file)
                found[given] = f"mesh_{len(found)}{suffix}"
                meshes[found[given]] = content
            mesh.set("filename", found[given])
    for old in root.findall("mujoco"):
        root.remove(old)
    own = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(own, "compiler", COMPILER)
    text = ElementTree.tostring(root, encoding="unicode")
    return Urdf(text, meshes, {name: given for given, name in found.items()})


def _in_degrees(path: Path, turns: list[str]) -> bool:
    """Return whether the limits of a revolute joint are probably in degrees."""
    try:
        values = np.array([float(turn) for turn in turns])
    except ValueError as error:
        raise InputError(
            f"{path}: limits of a joint must be numbers, got {', '.join(turns)}"
        ) from error
    most = np.abs(values).max(initial=0.0)
    return bool(MAX_TURN < most <= FULL_TURN) and not np.any(values % DEGREES)


def _is_possible(inertial: ElementTree.Element) -> bool:
    """Return whether an <inertial> has a mass and an inertia, both positive."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        return False
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    try:
        value = float(mass.get("value", 0.0))
        xx, yy, zz, xy, xz, yz = (float(inertia.get(name, 0.0)) for name in names)
    except ValueError:
        # MuJoCo names the place of what is no number.
        return True
    matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # MuJoCo raises what is zero to its bounds.
    return bool(np.isfinite(matrix).all()) and value >= 0 and np.linalg.eigvalsh(matrix)[0] >= 0


def _mesh_file(path: Path, link: str, given: str, folders: list[Path]) -> Path:
    """Return the file of a mesh path of a URDF."""
    parsed = urlparse(given)
    above = list(path.resolve().parents)
    if parsed.scheme in ("package", "model"):
        package, inside = parsed.netloc, unquote(parsed.path).lstrip("/")
        places = [
            place
            for folder in (*folders, *above)
            for place in (
                folder / package / inside,
                *([folder / inside] if folder.resolve().name == package else []),
            )
        ]
        hint = f"; --package-dir must name the folder that holds the package {package!r}"
    elif parsed.scheme == "file":
        places, hint = [Path(unquote(parsed.path))], ""
    else:
        places, hint = [path.parent / given, *(folder / given for folder in folders)], ""
    for place in places:
        if place.is_file():
            return place
    if not given:
        raise InputError(f"{path}: a mesh of link {link!r} has no filename")
    raise InputError(f"{path}: the mesh {given} of link {link!r} is missing{hint}")


def _check_tree(path: Path, root: ElementTree.Element) -> None:
    """Check that every link has one parent, and that one link has none."""
    links = {str(link.get("name")) for link in root.findall("link")}
    if not links:
        raise InputError(f"{path}: the URDF has no <link>")
    parent: dict[str, str] = {}
    for joint in root.findall("joint"):
        name = joint.get("name")
        ends = [joint.find(tag) for tag in ("parent", "child")]
        above, below = ("" if end is None else end.get("link", "") for end in ends)
        for end in (above, below):
            if end not in links:
                raise InputError(f"{path}: joint {name!r} names the link {end!r}, which is missing")
        if below in parent:
            raise InputError(
                f"{path}: link {below!r} has two parents, {parent[below]!r} and {above!r}; the "
                "joints of a URDF must form a tree: write closed loops as an MJCF with <connect>"
            )
        parent[below] = above
    for link in links:
        walked, now = {link}, parent.get(link)
        while now is not None:
            if now in walked:
                raise InputError(f"{path}: the joints form a loop through link {now!r}")
            walked.add(now)
            now = parent.get(now)

"""Export a fitted solid as a body for simulators and planners: MJCF and URDF."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import SubElement

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.errors import DeviceError
from eyehand.perception import Superquadric
from eyehand.perception.superquadric import EDGE_EXPONENT

WATER_DENSITY = 1000.0
"""Default density, kg/m³, as in MuJoCo."""
ROUND = 1.0
"""Exponent of an elliptic section."""
EXACT = 1e-6
"""Tolerance for rounding, of exponents and, relative to their length, of semi-axes."""
MESH_RESOLUTION = 64
"""Points around a mesh. The facets of a 100 mm ball lie within 0.13 mm of its surface."""
CLOUD_LINK = "cloud"
"""URDF link of the cloud's frame."""


@dataclass(frozen=True)
class Primitive:
    """A built-in shape of simulators."""

    shape: str
    """Name in MuJoCo: sphere, ellipsoid, cylinder or box."""
    size: tuple[float, ...]
    """Radius; semi-axes; radius and half length; or half edges, m."""


@dataclass(frozen=True)
class RobotFiles:
    """The texts of the two files. They refer to mesh files in the same folder."""

    mjcf: str
    """MuJoCo model."""
    urdf: str
    """Model for ROS and most simulators."""


def primitive(solid: Superquadric) -> Primitive | None:
    """Return the primitive equal to the solid, or None if only a mesh has its shape.

    A round section has exponent 1. A sharp edge has at most the exponent of fitted
    cylinders (`EDGE_EXPONENT`). That of fitted boxes is lower.
    """
    e1, e2 = solid.exponents
    a = [float(value) for value in solid.semi_axes]
    if any(solid.taper):
        return None
    round1, round2 = abs(e1 - ROUND) <= EXACT, abs(e2 - ROUND) <= EXACT
    edge = EDGE_EXPONENT + EXACT
    circular = abs(a[0] - a[1]) <= EXACT * a[0]
    if round1 and round2:
        if circular and abs(a[0] - a[2]) <= EXACT * a[0]:
            return Primitive("sphere", (a[0],))
        return Primitive("ellipsoid", (a[0], a[1], a[2]))
    if e1 <= edge and round2 and circular:
        return Primitive("cylinder", (a[0], a[2]))
    if e1 <= edge and e2 <= edge:
        return Primitive("box", (a[0], a[1], a[2]))
    return None


def robot_files(
    name: str,
    parts: Sequence[Superquadric],
    mesh_names: Mapping[int, str],
    meshes: Mapping[str, bytes],
    *,
    density: float = WATER_DENSITY,
    note: str = "",
) -> RobotFiles:
    """Describe solids as one free body in MJCF and URDF, and check that MuJoCo loads both.

    The body frame is that of the first solid, at its pose in the cloud. MuJoCo computes mass,
    centre and inertia for the URDF from the geometry and `density`. Overlaps count twice.

    Parameters
    ----------
    name
        Name of the body. Characters other than letters, digits and _ become _.
    parts
        Solids in the cloud's frame, at least one.
    mesh_names
        Number of a part → STL or OBJ file of the solid in its own axes, m. A part without a mesh
        must be a primitive. An ellipsoid needs a mesh, because URDF has no ellipsoid.
    meshes
        Contents of those files by name.
    density
        kg/m³.
    note
        A comment line for the files.

    Raises
    ------
    DeviceError
        If MuJoCo cannot be loaded or rejects a file.
    """
    name = re.sub(r"\W", "_", name) or "solid"
    T_body_cloud = parts[0].pose.inv()
    places = [T_body_cloud * part.pose for part in parts]
    mjcf = _mjcf(name, parts, places, mesh_names, density, note)
    body = _compiled(mjcf, meshes)
    urdf = _urdf(name, parts, places, mesh_names, body, note)
    _compiled(urdf, meshes)
    return RobotFiles(mjcf, urdf)


def needs_mesh(solid: Superquadric) -> bool:
    """Return whether MJCF or URDF has no primitive for the solid."""
    found = primitive(solid)
    return found is None or found.shape == "ellipsoid"


def _mjcf(
    name: str,
    parts: Sequence[Superquadric],
    places: Sequence[RigidTransform],
    mesh_names: Mapping[int, str],
    density: float,
    note: str,
) -> str:
    root = ElementTree.Element("mujoco", model=name)
    asset = SubElement(root, "asset")
    world = SubElement(root, "worldbody")
    body = SubElement(world, "body", {"name": name, **_place(parts[0].pose)})
    SubElement(body, "freejoint", name=f"{name}_free")
    for number, (solid, place) in enumerate(zip(parts, places, strict=True)):
        found = primitive(solid)
        if found is None:
            mesh = f"{name}_{number}"
            SubElement(asset, "mesh", name=mesh, file=mesh_names[number], inertia="exact")
            shape = {"type": "mesh", "mesh": mesh}
        else:
            shape = {"type": found.shape, "size": _text(found.size)}
        own = {"name": f"{name}_{number}", **shape, **_place(place), "density": f"{density:g}"}
        SubElement(body, "geom", own)
    if not len(asset):
        root.remove(asset)
    return _document(root, note)


def _urdf(
    name: str,
    parts: Sequence[Superquadric],
    places: Sequence[RigidTransform],
    mesh_names: Mapping[int, str],
    body: _Body,
    note: str,
) -> str:
    root = ElementTree.Element("robot", name=name)
    SubElement(root, "link", name=CLOUD_LINK)
    joint = SubElement(root, "joint", name=f"{name}_place", type="floating")
    SubElement(joint, "parent", link=CLOUD_LINK)
    SubElement(joint, "child", link=name)
    SubElement(joint, "origin", _origin(parts[0].pose))
    link = SubElement(root, "link", name=name)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "origin", xyz=_text(body.centre), rpy="0 0 0")
    SubElement(inertial, "mass", value=f"{body.mass:.6g}")
    moments = {
        f"i{'xyz'[row]}{'xyz'[column]}": f"{body.inertia[row, column]:.6g}"
        for row in range(3)
        for column in range(row, 3)
    }
    SubElement(inertial, "inertia", moments)
    for number, (solid, place) in enumerate(zip(parts, places, strict=True)):
        for role in ("visual", "collision"):
            element = SubElement(link, role, name=f"{name}_{number}_{role}")
            SubElement(element, "origin", _origin(place))
            geometry = SubElement(element, "geometry")
            _urdf_shape(geometry, solid, mesh_names.get(number))
    return _document(root, note)


def _urdf_shape(geometry: ElementTree.Element, solid: Superquadric, mesh: str | None) -> None:
    if needs_mesh(solid):
        assert mesh is not None
        SubElement(geometry, "mesh", filename=mesh)
        return
    found = primitive(solid)
    assert found is not None
    if found.shape == "sphere":
        SubElement(geometry, "sphere", radius=_text(found.size))
    elif found.shape == "box":
        SubElement(geometry, "box", size=_text([2 * half for half in found.size]))
    else:
        radius, half = found.size
        SubElement(geometry, "cylinder", radius=_text([radius]), length=_text([2 * half]))


@dataclass(frozen=True)
class _Body:
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    """About the centre, along the body axes, (3, 3), kg m²."""


def _compiled(text: str, meshes: Mapping[str, bytes]) -> _Body:
    mujoco = import_mujoco()
    try:
        model: Any = mujoco.MjModel.from_xml_string(text, dict(meshes))
    except ValueError as error:
        fault = " ".join(str(error).split())
        raise DeviceError(f"MuJoCo rejects the solid: {fault}") from error
    body = int(model.jnt_bodyid[0])
    turn = Rotation.from_quat(model.body_iquat[body], scalar_first=True).as_matrix()
    inertia = turn @ np.diag(model.body_inertia[body]) @ turn.T
    return _Body(float(model.body_mass[body]), np.array(model.body_ipos[body]), inertia)


def _place(pose: RigidTransform) -> dict[str, str]:
    quaternion = pose.rotation.as_quat(scalar_first=True)
    return {"pos": _text(pose.translation), "quat": _text(quaternion)}


def _origin(pose: RigidTransform) -> dict[str, str]:
    # In gimbal lock one Euler angle is free, and SciPy warns. Any choice is valid.
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        angles = pose.rotation.as_euler("xyz")
    return {"xyz": _text(pose.translation), "rpy": _text(angles)}


def _text(values: Any) -> str:
    # Adding 0 turns -0 into 0.
    return " ".join(f"{round(float(value), 9) + 0.0:.9g}" for value in np.ravel(values))


def _document(root: ElementTree.Element, note: str) -> str:
    if note:
        # Two hyphens end a comment in XML.
        root.insert(0, ElementTree.Comment(f" {note.replace('--', '- -')} "))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"

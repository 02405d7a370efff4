"""Rigid objects of convex pieces: the collision geometry as its file has it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError
from eyehand.perception.io import read_mesh

from ..mujoco_import import import_mujoco
from .convex_pieces import convex_pieces
from .object_folder import URDF_SUFFIX, read_objects
from .tabletop_spec import PHYSICS_GROUP

PIECE_VERTICES = 64
"""Maximum number of vertices of a piece's hull. The files have at most 64."""


@dataclass(frozen=True, eq=False)
class PieceObject:
    """A rigid object. The camera sees its surface; contacts use its convex pieces.

    The frame is that of the file. Its origin is the centre of mass, as the public clutter-removal
    protocol has it, because the URDF files name no other.
    """

    name: str
    """Name of the file without suffix."""
    vertices: NDArray[np.float64]
    """Vertices of the visible surface, (V, 3), m."""
    faces: NDArray[np.int64]
    """Triangles of the visible surface, (T, 3)."""
    pieces: tuple[NDArray[np.float64], ...]
    """Vertices of each convex piece, (P, 3), m."""
    mass: float
    """Mass, kg."""

    def scaled(self, factor: float) -> PieceObject:
        """Return the object with all lengths multiplied by a factor; the mass stays."""
        return PieceObject(
            self.name,
            self.vertices * factor,
            self.faces,
            tuple(piece * factor for piece in self.pieces),
            self.mass,
        )

    @property
    def corners(self) -> NDArray[np.float64]:
        """Vertices of all pieces, (N, 3), m."""
        return np.concatenate(self.pieces)


def read_piece_objects(folder: Path | str, density: float | None = None) -> tuple[PieceObject, ...]:
    """Read the objects of a folder with their convex pieces, sorted by name.

    Files and density are as :func:`.read_objects` describes them. If each connected part of the
    collision mesh is a closed convex solid, the parts are the pieces. Otherwise the piece is the
    convex hull of the mesh: cavities such as that of a cup are then filled.

    Raises
    ------
    InputError
        As :func:`.read_objects`.
    """
    found = []
    for item in read_objects(folder, density):
        surface = _surface(item.file, "visual") or _surface(item.file, "collision")
        solid = _surface(item.file, "collision") or surface
        assert surface is not None
        assert solid is not None
        found.append(
            PieceObject(
                item.file.stem,
                *surface,
                _pieces(*solid),
                float(item.mass),
            )
        )
    return tuple(sorted(found, key=lambda item: item.name))


def add_piece_object(spec: Any, item: PieceObject, name: str, friction: float) -> Any:
    """Add an object as a body with a free joint at the origin, and return the body.

    Parameters
    ----------
    spec
        `MjSpec` of the world.
    item
        The object.
    name
        Name of the body, unique in the world. The visible geom has the same name.
    friction
        Coulomb friction coefficient.
    """
    mujoco = import_mujoco()
    body = spec.worldbody.add_body(name=name)
    body.add_freejoint(name=name)
    # Bullet takes the inertia of the bounding box.
    low, high = item.corners.min(axis=0), item.corners.max(axis=0)
    square = (high - low) ** 2
    body.mass, body.ipos = item.mass, [0.0, 0.0, 0.0]
    body.inertia = item.mass / 12.0 * (square.sum() - square)
    body.explicitinertial = True
    seen = spec.add_mesh(name=name, uservert=item.vertices.ravel(), userface=item.faces.ravel())
    seen.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    geom = body.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, contype=0, conaffinity=0, group=1
    )
    geom.meshname, geom.mass = name, 0.0
    for number, piece in enumerate(item.pieces):
        label = f"{name}_piece_{number}"
        mesh = spec.add_mesh(name=label, uservert=piece.ravel())
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        mesh.maxhullvert = PIECE_VERTICES
        part = body.add_geom(name=label, type=mujoco.mjtGeom.mjGEOM_MESH, group=PHYSICS_GROUP)
        part.meshname, part.mass = label, 0.0
        set_grip_contact(part, friction)
    return body


def set_grip_contact(geom: Any, friction: float) -> None:
    """Set the friction and stiffness of a geom that is gripped, grips, or carries objects."""
    geom.condim = 4
    geom.friction = [friction, TORSION_M, 0.0]
    geom.solref, geom.solimp = [0.006, 1.0], [0.95, 0.99, 0.001, 0.5, 2.0]


TORSION_M = 0.01
"""Torsional friction over normal force, m: a soft pad of 10 mm radius."""


def _pieces(
    vertices: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float64], ...]:
    """Return the vertices of each convex piece of a mesh, or of the whole mesh."""
    # Pieces that touch have equal corners. Merging these would join them.
    pieces = convex_pieces(vertices, faces)
    if not pieces:
        # It closes the surface of a file that repeats the corners of each triangle.
        corners, index = np.unique(vertices.round(9), axis=0, return_inverse=True)
        pieces = convex_pieces(corners, index[faces])
    return pieces or (vertices[np.unique(faces)],)


def _surface(file: Path, kind: str) -> tuple[NDArray[np.float64], NDArray[np.int64]] | None:
    """Read the mesh of a URDF's link, or a mesh file; None if the URDF has no such mesh."""
    if file.suffix.lower() != URDF_SUFFIX:
        return read_mesh(file)
    mesh = ElementTree.parse(file).getroot().find(f"link/{kind}/geometry/mesh")
    if mesh is None:
        return None
    vertices, faces = read_mesh(file.parent / Path(mesh.get("filename", "")).name)
    scale = np.array([float(word) for word in mesh.get("scale", "1 1 1").split()])
    if scale.shape != (3,):
        raise InputError(f"{file}: mesh scale must be 3 numbers, got {mesh.get('scale')!r}")
    return vertices * scale, faces

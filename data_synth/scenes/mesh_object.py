"""Rigid objects in the simulated world whose shape is a triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from ..mujoco_import import import_mujoco
from .convex_pieces import hull_volume
from .tabletop_spec import OBJECT_MATERIAL, PHYSICS_GROUP, set_contact

HULL_VERTICES = 64
"""Maximum number of vertices of the hull used for contacts. More is more exact for round objects,
and slower."""


# Comparing arrays gives arrays, so two objects are equal only if they are identical.
@dataclass(frozen=True, eq=False)
class MeshObject:
    """A rigid object. The camera sees its mesh; contacts use its convex pieces, or its hull."""

    name: str
    """Name, unique in the scene."""
    vertices: NDArray[np.float64]
    """Vertices in the object's frame, (V, 3), m."""
    faces: NDArray[np.int64]
    """Triangles, (T, 3)."""
    mass: float
    """Mass, kg."""
    colour: tuple[float, float, float]
    """Red, green, blue, each in [0, 1]."""
    pose: RigidTransform
    """T_world_object."""
    pieces: tuple[NDArray[np.float64], ...] = ()
    """Vertices of each convex piece, (P, 3), m. Contacts and inertia use the pieces; if empty, they
    use the hull of the mesh."""
    shares: tuple[float, ...] = ()
    """Share of the mass of each piece; if empty, the pieces have one density."""

    @property
    def centre(self) -> NDArray[np.float64]:
        """Origin of the object's frame, (3,), world, m."""
        return self.pose.translation

    @property
    def radius(self) -> float:
        """Maximum distance of a vertex from that origin, m."""
        return float(np.linalg.norm(self.vertices, axis=1).max())

    def at(self, pose: RigidTransform) -> MeshObject:
        """Return the same object with another T_world_object."""
        return replace(self, pose=pose)


def add_mesh_object(spec: Any, item: MeshObject, *, free: bool = True) -> None:
    """Add an object as a body with its name to a scene's `MjSpec`, with a free joint or fixed.

    The inertia is that of the pieces, or of the hull, each with a uniform density.
    """
    mujoco = import_mujoco()
    body = spec.worldbody.add_body(name=item.name, pos=item.centre)
    body.quat = item.pose.rotation.as_quat(scalar_first=True)
    if free:
        body.add_freejoint()
    solids = item.pieces if len(item.pieces) > 1 else ()
    mesh = spec.add_mesh(
        name=item.name,
        uservert=np.asarray(item.vertices, dtype=np.float64).ravel(),
        userface=np.asarray(item.faces, dtype=np.int32).ravel(),
    )
    # Scanned meshes have holes; their hull always has a volume.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    mesh.maxhullvert = HULL_VERTICES
    geom = body.add_geom(name=item.name, type=mujoco.mjtGeom.mjGEOM_MESH)
    geom.meshname, geom.material, geom.rgba = item.name, OBJECT_MATERIAL, [*item.colour, 1.0]
    if not solids:
        geom.mass = item.mass
        set_contact(geom)
        return
    geom.mass, geom.contype, geom.conaffinity = 0.0, 0, 0
    weights = np.array(item.shares or [hull_volume(piece) for piece in solids])
    for number, (piece, share) in enumerate(zip(solids, weights / weights.sum(), strict=True)):
        label = f"{item.name}_piece_{number}"
        shape = spec.add_mesh(name=label, uservert=piece.ravel())
        shape.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        shape.maxhullvert = HULL_VERTICES
        part = body.add_geom(name=label, type=mujoco.mjtGeom.mjGEOM_MESH, group=PHYSICS_GROUP)
        part.meshname, part.mass = label, item.mass * float(share)
        set_contact(part)

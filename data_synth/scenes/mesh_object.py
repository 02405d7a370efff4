"""Rigid objects in the simulated world whose shape is a triangle mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..mujoco_import import import_mujoco
from .tabletop_spec import OBJECT_MATERIAL, set_contact

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

HULL_VERTICES = 64
"""Maximum number of vertices of the hull used for contacts. More is more exact for round objects,
and slower."""


# Comparing arrays gives arrays, so two objects are equal only if they are identical.
@dataclass(frozen=True, eq=False)
class MeshObject:
    """A rigid object. The camera sees its mesh; contacts use its convex hull."""

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
    """Add an object as a body with its name to a scene's `MjSpec`, with a free joint or fixed."""
    mujoco = import_mujoco()
    mesh = spec.add_mesh(
        name=item.name,
        uservert=np.asarray(item.vertices, dtype=np.float64).ravel(),
        userface=np.asarray(item.faces, dtype=np.int32).ravel(),
    )
    # Scanned meshes have holes; their hull always has a volume.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    mesh.maxhullvert = HULL_VERTICES
    body = spec.worldbody.add_body(name=item.name, pos=item.centre)
    body.quat = item.pose.rotation.as_quat(scalar_first=True)
    if free:
        body.add_freejoint()
    geom = body.add_geom(name=item.name, type=mujoco.mjtGeom.mjGEOM_MESH, mass=item.mass)
    geom.meshname, geom.material, geom.rgba = item.name, OBJECT_MATERIAL, [*item.colour, 1.0]
    set_contact(geom)

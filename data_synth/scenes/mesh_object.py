"""Objects of any shape in the simulated world: a mesh at a place, its hull what is felt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..mujoco_import import import_mujoco
from .tabletop_spec import set_contact

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

HULL_VERTICES = 64
"""Most corners of the hull that collides: more is truer to round things, and slower."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class MeshObject:
    """One rigid object; the camera sees its surface, and touch meets its convex hull."""

    name: str
    """Its own in the scene."""
    vertices: NDArray[np.float64]
    """Corners of the surface in the object's frame, (V, 3), m."""
    faces: NDArray[np.int64]
    """Triangles, (T, 3)."""
    mass: float
    """kg."""
    colour: tuple[float, float, float]
    """Red, green, blue, each in [0, 1]."""
    pose: RigidTransform
    """T_world_object."""

    @property
    def centre(self) -> NDArray[np.float64]:
        """Origin of its frame, (3,), world, m."""
        return self.pose.translation

    @property
    def radius(self) -> float:
        """Largest distance of a corner from that origin, m."""
        return float(np.linalg.norm(self.vertices, axis=1).max())


def add_mesh_object(spec: Any, item: MeshObject) -> None:
    """Add a mesh as a free body of its name to a scene's `MjSpec`."""
    mujoco = import_mujoco()
    mesh = spec.add_mesh(
        name=item.name,
        uservert=np.asarray(item.vertices, dtype=np.float64).ravel(),
        userface=np.asarray(item.faces, dtype=np.int32).ravel(),
    )
    # Scanned surfaces have holes: the hull always has a volume.
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    mesh.maxhullvert = HULL_VERTICES
    body = spec.worldbody.add_body(name=item.name, pos=item.centre)
    body.quat = item.pose.rotation.as_quat(scalar_first=True)
    body.add_freejoint()
    geom = body.add_geom(name=item.name, type=mujoco.mjtGeom.mjGEOM_MESH, mass=item.mass)
    geom.meshname, geom.material, geom.rgba = item.name, "object", [*item.colour, 1.0]
    set_contact(geom)

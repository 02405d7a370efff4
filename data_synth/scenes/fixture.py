"""Fixed rigid parts of a scene: floors, tables, walls of containers, furniture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform

from ..mujoco_import import import_mujoco
from .convex_mesh import hull_mesh
from .tabletop_spec import FLOOR_EXTENT_M, FLOOR_FACET_M, OBJECT_MATERIAL, set_contact

BackgroundKind = Literal[
    "floor",
    "table",
    "container_floor",
    "container_wall",
    "board",
    "wall",
    "surroundings",
    "robot",
]
"""What a pixel shows that shows no object. ``container_wall`` includes the rim, ``table`` its legs.
``board`` is a shelf's board, ``wall`` a wall of a room or a shelf. ``surroundings`` are chairs,
screens and other furniture."""
BACKGROUND_LEGEND: dict[int, BackgroundKind] = dict(enumerate(get_args(BackgroundKind), start=1))
"""Number of each kind in background images; 0 is an object, or nothing in range."""
BACKGROUND_NUMBER: dict[BackgroundKind, int] = {
    kind: number for number, kind in BACKGROUND_LEGEND.items()
}

Colour = tuple[float, float, float]
Outline = Literal["box", "cylinder", "capsule", "sphere", "ellipsoid", "hull", "plane"]


# Comparing arrays gives arrays, so two fixtures are equal only if they are identical.
@dataclass(frozen=True, eq=False)
class Fixture:
    """A convex solid that never moves."""

    kind: BackgroundKind
    """Kind of background that its pixels show."""
    outline: Outline
    """Kind of solid. A plane is infinite, and its normal is its z-axis."""
    half_size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Half extents along its own axes, m; those of a capsule without its round ends."""
    corners: NDArray[np.float64] | None = None
    """Points (N, 3) of which a ``hull`` is the convex hull, in its own frame, m."""
    pose: RigidTransform = RigidTransform.identity()  # noqa: RUF009 - immutable
    """T_world_fixture."""
    colour: Colour = (0.62, 0.63, 0.65)
    """Red, green, blue, each in [0, 1]."""

    def moved(self, T_world_old: RigidTransform) -> Fixture:
        """Return the fixture with its pose moved by a transform."""
        return replace(self, pose=T_world_old * self.pose)


def box(kind: BackgroundKind, low: ArrayLike, high: ArrayLike, colour: Colour) -> Fixture:
    """Return an upright box between two opposite corners (3,), m."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    x, y, z = (high - low) / 2
    centre = RigidTransform.from_translation((low + high) / 2)
    return Fixture(kind, "box", (float(x), float(y), float(z)), pose=centre, colour=colour)


def hull(kind: BackgroundKind, corners: ArrayLike, colour: Colour) -> Fixture:
    """Return the convex hull of points (N, 3), m."""
    return Fixture(kind, "hull", corners=np.asarray(corners, dtype=np.float64), colour=colour)


def add_fixture(spec: Any, name: str, item: Fixture, *, visuals: bool) -> None:
    """Add a fixture to a scene's `MjSpec` as a geom of the world with this name."""
    mujoco = import_mujoco()
    types = mujoco.mjtGeom
    geom = spec.worldbody.add_geom(name=name, pos=item.pose.translation)
    geom.quat = item.pose.rotation.as_quat(scalar_first=True)
    geom.rgba = [*item.colour, 1.0]
    if item.outline == "hull":
        assert item.corners is not None
        vertices, faces = hull_mesh(item.corners)
        mesh = spec.add_mesh(name=name, uservert=vertices.ravel(), userface=faces.ravel())
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        geom.type, geom.meshname = types.mjGEOM_MESH, name
    elif item.outline == "plane":
        half = FLOOR_EXTENT_M / 2
        geom.type, geom.size = types.mjGEOM_PLANE, [half, half, FLOOR_FACET_M]
    elif item.outline in ("cylinder", "capsule"):
        kinds = {"cylinder": types.mjGEOM_CYLINDER, "capsule": types.mjGEOM_CAPSULE}
        geom.type, geom.size = kinds[item.outline], [item.half_size[0], item.half_size[2], 0]
    else:
        kinds = {
            "box": types.mjGEOM_BOX,
            "sphere": types.mjGEOM_SPHERE,
            "ellipsoid": types.mjGEOM_ELLIPSOID,
        }
        geom.type, geom.size = kinds[item.outline], item.half_size
    set_contact(geom)
    if visuals:
        geom.material = OBJECT_MATERIAL

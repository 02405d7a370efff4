"""One MuJoCo model of a robot and of prepared geoms for obstacles.

A primitive shape is written into a prepared geom, a slot, without a new compilation.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from .collision_pairs import find_collision_geoms
from .mujoco_binding import Data, Model, Spec, mujoco
from .robot_model import RobotModel
from .robot_source import compile_spec
from .shapes import Box, Capsule, ConvexMesh, Cylinder, Ellipsoid, Shape, Sphere

CCD_TOLERANCE = 1e-12
"""Tolerance of MuJoCo's general convex distance, m. At its default of 1e-6, normals inside
ellipsoids and cylinders are wrong by up to 0.1; here they are wrong by 1e-5. Only these pairs take
longer, by a third."""
CCD_ITERATIONS = 500
"""Maximum number of iterations for that tolerance. Spheres, boxes and capsules need far fewer."""
FAR_AWAY_M = 1e3
"""Depth at which empty slots are kept, m. They are in no pair, but a viewer would draw them."""

_PREFIX = "eyehand_slot_"
_BALL = 0.01
"""Radius of a ball that stands for a visual mesh, m. It only gives a body without inertia one."""
_IDENTITY = [1.0, 0.0, 0.0, 0.0]
_GEOM_FIELDS: dict[str, Any] = {
    "pos": [0.0] * 3,
    "quat": _IDENTITY,
    "fromto": [math.nan] * 6,
    "contype": 1,
    "conaffinity": 1,
    "typeinertia": mujoco.mjtGeomInertia.mjINERTIA_VOLUME,
}
"""Fields of a new geom, so that no ``<default>`` of the robot's file applies. Such a default could
move an obstacle, or discard it as a visual geom. NaN in ``fromto`` means that it is not set."""
_MESH_FIELDS: dict[str, Any] = {
    "scale": [1.0] * 3,
    "refpos": [0.0] * 3,
    "refquat": _IDENTITY,
    "maxhullvert": -1,
}
"""Fields of a new mesh, for the same reason: a file with meshes in mm scales all meshes by a
``<default>``."""


@dataclass(frozen=True, eq=False)
class WorldModel:
    """A compiled robot with slots. Bodies and geoms of the robot keep their ids."""

    model: Model
    """The compiled ``MjModel``."""
    data: Data
    """Its ``MjData``."""
    slots: tuple[int, ...]
    """Prepared geoms, each for one shape that is not a mesh."""
    meshes: tuple[int, ...]
    """Geoms of the meshes, in the order of the arguments."""


class _Prepared:
    """What all worlds of a robot share: MuJoCo compiles the meshes of an arm for up to 0.4 s."""

    def __init__(self, robot: RobotModel) -> None:
        self.spec = robot.spec.copy()
        """The robot without the meshes that never collide."""
        _drop_visual_meshes(self.spec, robot)
        self.models: dict[int, Model] = {}
        """Models without meshes of obstacles, by their number of slots. Worlds use copies."""


_prepared: WeakKeyDictionary[RobotModel, _Prepared] = WeakKeyDictionary()


def build_world(robot: RobotModel, slots: int, meshes: Sequence[ConvexMesh]) -> WorldModel:
    """Return a world of a robot with empty slots and meshes."""
    prepared = _prepared.get(robot)
    if prepared is None:
        prepared = _prepared[robot] = _Prepared(robot)
    if meshes:
        model = _compile(prepared.spec, slots, meshes)
    else:
        if slots not in prepared.models:
            prepared.models[slots] = _compile(prepared.spec, slots, ())
        model = copy.copy(prepared.models[slots])
    return WorldModel(
        model,
        mujoco.MjData(model),
        tuple(model.geom(f"{_PREFIX}{number}").id for number in range(slots)),
        tuple(model.geom(f"{_PREFIX}mesh_{number}").id for number in range(len(meshes))),
    )


def _compile(spec: Spec, slots: int, meshes: Sequence[ConvexMesh]) -> Model:
    spec = spec.copy()
    spec.option.ccd_tolerance = CCD_TOLERANCE
    spec.option.ccd_iterations = CCD_ITERATIONS
    for number in range(slots):
        name = f"{_PREFIX}{number}"
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        _add_body(spec, name).add_geom(name=name, type=sphere, size=[1.0, 0.0, 0.0], **_GEOM_FIELDS)
    for number, mesh in enumerate(meshes):
        name = f"{_PREFIX}mesh_{number}"
        spec.add_mesh(name=name, uservert=mesh.vertices.ravel(), **_MESH_FIELDS)
        kind = mujoco.mjtGeom.mjGEOM_MESH
        _add_body(spec, name).add_geom(name=name, type=kind, meshname=name, **_GEOM_FIELDS)
    return compile_spec(spec)


def fill_slot(model: Model, geom: int, shape: Shape) -> None:
    """Write a shape that is not a mesh into a slot of the compiled model."""
    kind, size, radius, half = _geom_fields(shape)
    model.geom_type[geom] = kind
    model.geom_size[geom] = size
    model.geom_rbound[geom] = radius
    model.geom_aabb[geom] = [0.0, 0.0, 0.0, *half]


def _drop_visual_meshes(spec: Spec, robot: RobotModel) -> None:
    """Replace meshes that never collide by balls, so that the other geoms keep their ids."""
    colliding = find_collision_geoms(robot).names
    used = set()
    for original, geom in zip(robot.spec.geoms, spec.geoms, strict=True):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH and original.id not in colliding:
            geom.type, geom.meshname, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, "", [_BALL] * 3
        used.add(geom.meshname)
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)


def _add_body(spec: Spec, name: str) -> Spec:
    return spec.worldbody.add_body(name=name, mocap=True, pos=[0.0, 0.0, -FAR_AWAY_M])


def _geom_fields(shape: Shape) -> tuple[int, list[float], float, list[float]]:
    """Return MuJoCo's type and size (3,), bounding radius, and half extents of the bounding box."""
    kinds = mujoco.mjtGeom
    match shape:
        case Sphere(radius):
            return kinds.mjGEOM_SPHERE, [radius, 0.0, 0.0], radius, [radius] * 3
        case Capsule(radius, length):
            reach = radius + length
            return kinds.mjGEOM_CAPSULE, [radius, length, 0.0], reach, [radius, radius, reach]
        case Cylinder(radius, length):
            reach = float(np.hypot(radius, length))
            return kinds.mjGEOM_CYLINDER, [radius, length, 0.0], reach, [radius, radius, length]
        case Ellipsoid(axes):
            return kinds.mjGEOM_ELLIPSOID, axes.tolist(), float(axes.max()), axes.tolist()
        case Box(half):
            return kinds.mjGEOM_BOX, half.tolist(), float(np.linalg.norm(half)), half.tolist()
    raise AssertionError(f"a slot cannot hold a {type(shape).__name__}")

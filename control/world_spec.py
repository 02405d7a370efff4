"""A robot and room for obstacles as one MuJoCo model: primitives need no compiling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .mujoco_binding import mujoco
from .robot_source import compile_spec
from .shapes import Box, Capsule, ConvexMesh, Cylinder, Ellipsoid, Sphere

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .mujoco_binding import Data, Model, Spec
    from .shapes import Shape

CCD_TOLERANCE = 1e-12
"""Where MuJoCo's general convex distance stops: at its default of 1e-6 normals inside ellipsoids
and cylinders are wrong by up to 0.1, here by 1e-5, for a third more time in those pairs alone."""
CCD_ITERATIONS = 500
"""Enough for that tolerance; spheres, boxes and capsules never come near it."""
FAR_AWAY_M = 1e3
"""Where empty slots wait: they are in no pair, this is for whoever draws the model."""

_PREFIX = "eyehand_slot_"
_NO_TURN = [1.0, 0.0, 0.0, 0.0]
_OWN_GEOM: dict[str, Any] = {
    "pos": [0.0] * 3,
    "quat": _NO_TURN,
    "fromto": [math.nan] * 6,
    "contype": 1,
    "conaffinity": 1,
    "typeinertia": mujoco.mjtGeomInertia.mjINERTIA_VOLUME,
}
"""What a ``<default>`` of the robot's file must not decide: an obstacle would stand elsewhere, or
be discarded as a mere picture. No number in ``fromto`` says that it is not given."""
_OWN_MESH: dict[str, Any] = {
    "scale": [1.0] * 3,
    "refpos": [0.0] * 3,
    "refquat": _NO_TURN,
    "maxhullvert": -1,
}
"""Of a mesh: files whose meshes are in mm scale all of them by a ``<default>``."""


@dataclass(frozen=True, eq=False)
class WorldModel:
    """A compiled robot with slots; bodies and geoms of the robot keep their ids."""

    model: Model
    """The compiled ``MjModel``."""
    data: Data
    """Its ``MjData``."""
    slots: tuple[int, ...]
    """Geoms that any shape but a mesh can be put into."""
    meshes: tuple[int, ...]
    """Geoms of the meshes, in the order given."""
    probe: int
    """A sphere that is moved about to measure from points."""


def build_world(spec: Spec, slots: int, meshes: Sequence[ConvexMesh]) -> WorldModel:
    """Compile a robot with empty slots, meshes and a probe; ``spec`` is left as it is."""
    spec = spec.copy()
    spec.option.ccd_tolerance = CCD_TOLERANCE
    spec.option.ccd_iterations = CCD_ITERATIONS
    for number in range(slots + 1):
        name = f"{_PREFIX}{number}"
        sphere = mujoco.mjtGeom.mjGEOM_SPHERE
        _add_body(spec, name).add_geom(name=name, type=sphere, size=[1.0, 0.0, 0.0], **_OWN_GEOM)
    for number, mesh in enumerate(meshes):
        name = f"{_PREFIX}mesh_{number}"
        spec.add_mesh(name=name, uservert=mesh.vertices.ravel(), **_OWN_MESH)
        kind = mujoco.mjtGeom.mjGEOM_MESH
        _add_body(spec, name).add_geom(name=name, type=kind, meshname=name, **_OWN_GEOM)
    model = compile_spec(spec)
    ids = [model.geom(f"{_PREFIX}{number}").id for number in range(slots + 1)]
    return WorldModel(
        model,
        mujoco.MjData(model),
        tuple(ids[1:]),
        tuple(model.geom(f"{_PREFIX}mesh_{number}").id for number in range(len(meshes))),
        ids[0],
    )


def fill_slot(model: Model, geom: int, shape: Shape) -> None:
    """Give a slot's geom a shape that is no mesh, in place."""
    kind, size, radius, half = _geom_of(shape)
    model.geom_type[geom] = kind
    model.geom_size[geom] = size
    model.geom_rbound[geom] = radius
    model.geom_aabb[geom] = [0.0, 0.0, 0.0, *half]


def _add_body(spec: Spec, name: str) -> Spec:
    return spec.worldbody.add_body(name=name, mocap=True, pos=[0.0, 0.0, -FAR_AWAY_M])


def _geom_of(shape: Shape) -> tuple[int, list[float], float, list[float]]:
    """MuJoCo's type and size (3,), the bounding radius and the half extents of the bounding box."""
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
    raise AssertionError(f"a {type(shape).__name__} does not fit a slot")

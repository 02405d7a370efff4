"""Prepare MuJoCo descriptions (`MjSpec`) for being joined into one world."""

from __future__ import annotations

from typing import Any

import numpy as np

_SIZES = (
    "njmax",
    "nconmax",
    "nuser_body",
    "nuser_jnt",
    "nuser_geom",
    "nuser_site",
    "nuser_cam",
    "nuser_tendon",
    "nuser_actuator",
    "nuser_sensor",
)
"""Array sizes that MuJoCo computes itself if they are -1."""
_WITH_USER_DATA = (
    "bodies",
    "joints",
    "geoms",
    "sites",
    "cameras",
    "tendons",
    "actuators",
    "sensors",
)
"""Kinds of elements that can carry user data, which nothing here reads."""
_VISUAL = ("headlight", "map", "quality", "rgba", "scale")


def prepare_for_attachment(spec: Any) -> None:
    """Remove array sizes, user data and keyframes from a spec (`MjSpec`).

    MuJoCo would warn of each that differs from the world to which the spec is attached.
    """
    for key in list(spec.keys):
        spec.delete(key)
    spec.nkey = 0
    for name in _SIZES:
        setattr(spec, name, -1)
    for kind in _WITH_USER_DATA:
        for item in getattr(spec, kind):
            item.userdata = []


def match_options(parent: Any, child: Any) -> None:
    """Copy the physics and drawing options of a spec to the one that will be attached to it.

    MuJoCo would warn of each that differs, on standard error.
    """
    parts = [(parent.option, child.option)]
    for name in _VISUAL:
        parts.append((getattr(parent.visual, name), getattr(child.visual, name)))
    for source, target in parts:
        for name in dir(source):
            if not name.startswith("_"):
                setattr(target, name, getattr(source, name))


def set_base(spec: Any, T_world_base: Any) -> None:
    """Move the root bodies of a robot from the world's origin to a base pose."""
    for root in spec.worldbody.bodies:
        rotation = type(T_world_base.rotation).from_quat(np.asarray(root.quat), scalar_first=True)
        moved = T_world_base * type(T_world_base).from_components(root.pos, rotation)
        root.pos = moved.translation
        root.quat = moved.rotation.as_quat(scalar_first=True)


def remove_visual_geoms(spec: Any, model: Any | None = None) -> None:
    """Remove the geoms of a spec (`MjSpec`) that touch nothing, and their meshes.

    MuJoCo compiles meshes without a geom too: those of a Panda take 0.36 s.

    Parameters
    ----------
    spec
        The spec.
    model
        Its `MjModel`, whose inertia the bodies keep: in some files the removed geoms have it. All
        bodies must have names. None if the other geoms have it.
    """
    for geom in list(spec.geoms):
        if geom.contype == 0 and geom.conaffinity == 0:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
    if model is None:
        return
    for body in spec.bodies[1:]:
        if not body.explicitinertial:
            part = model.body(body.name)
            body.explicitinertial, body.mass, body.inertia = True, part.mass[0], part.inertia
            body.ipos, body.iquat = part.ipos, part.iquat

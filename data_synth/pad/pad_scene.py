"""Scenes for touch: one or more arms with a tactile pad as fingertip, and objects."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..arms import LBR_ARM, TOOL_SITE
from ..mujoco_import import import_mujoco
from .foam import Foam, PadOptions
from .tactile_pad import IMAGE_RATE, PAD_SITE
from .touch_objects import TouchObject

PAD_BODY = "pad"
"""Name of the body that carries the pad."""
PAD_STANDOFF = 0.04
"""Distance from the arm's flange to the foam's surface, m: the pad's plate and electronics."""
_RIGID_BIT, _SOFT_BIT = 1, 2
"""Bits of MuJoCo's own contacts. The pad's plate and the arms collide with rigid objects only,
because the bed models the deformation of soft ones. All objects collide with one another and with
the table."""
_PLATE_MARGIN = 0.002
_PAD_MASS = 0.25
_FOAM_COLOUR = (0.16, 0.17, 0.19, 1.0)
_PLATE_COLOUR = (0.75, 0.77, 0.8, 1.0)
_BASE_BODY = "base"
_IMPRATIO = 100.0


@dataclass(frozen=True)
class PlacedObject:
    """An object in the scene.

    Raises
    ------
    InputError
        If a free object has no mass.
    """

    touch_object: TouchObject
    """The object."""
    T_world_object: RigidTransform = field(default_factory=RigidTransform.identity)
    """Pose of the object."""
    motion: str = "fixed"
    """"fixed", "free" (moved by forces) or "mocap" (its pose is set from outside)."""
    mass: float = 0.1
    """Mass of a free object, kg."""

    def __post_init__(self) -> None:
        if self.motion not in ("fixed", "free", "mocap"):
            raise InputError(f"motion must be fixed, free or mocap, got {self.motion!r}")
        if self.motion == "free" and not 0 < self.mass < np.inf:
            raise InputError(f"a free object's mass must be > 0 kg, got {self.mass}")


@dataclass(frozen=True)
class Arm:
    """An arm with a pad in the scene."""

    T_world_base: RigidTransform = field(default_factory=RigidTransform.identity)
    """Pose of the arm's base."""
    prefix: str = ""
    """Prefix of the names of its bodies, joints and site ("left_joint1"). With several arms each
    needs its own."""


@dataclass(frozen=True)
class PadScene:
    """A compiled scene."""

    model: Any
    """``mujoco.MjModel``."""
    sites: tuple[str, ...]
    """Sites of the pads, one per arm."""
    joints: tuple[tuple[str, ...], ...]
    """Names of each arm's joints, from the base up."""
    softness: dict[str, Foam]
    """Foam of each geom that is not rigid, by name."""
    pad: PadOptions
    """Options of the pads."""


def pad_scene(
    objects: tuple[PlacedObject, ...] = (),
    arms: tuple[Arm, ...] = (Arm(),),
    pad: PadOptions | None = None,
) -> PadScene:
    """Build a scene for touch.

    Parameters
    ----------
    objects
        Objects to touch. Names must differ.
    arms
        One or more; prefixes must differ.
    pad
        Options of the pad of every arm.

    Returns
    -------
    PadScene
        The compiled scene. Its time step is that of the pad's images, its integrator
        `implicitfast`.

    Raises
    ------
    InputError
        If two names or prefixes are the same.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    mujoco = import_mujoco()
    options = pad or PadOptions()
    names = [item.touch_object.name for item in objects]
    prefixes = [arm.prefix for arm in arms]
    for kind, given in (("objects", names), ("arms", prefixes)):
        if len(set(given)) < len(given):
            raise InputError(f"names of {kind} must differ, got {given}")
    if len(arms) > 1 and "" in prefixes:
        raise InputError(f"each of several arms needs a prefix, got {prefixes}")
    spec = _cell(mujoco, arms, options)
    softness: dict[str, Foam] = {}
    for item in objects:
        softness.update(_add_object(spec, item))
    model = spec.compile()
    joints = [model.joint(number).name for number in range(model.njnt)]
    return PadScene(
        model,
        tuple(prefix + PAD_SITE for prefix in prefixes),
        tuple(tuple(j for j in joints if j.startswith(f"{prefix}joint")) for prefix in prefixes),
        softness,
        options,
    )


def padded_arm(pad: PadOptions | None = None) -> Any:
    """Describe the arm with a pad at its flange, for a robot model.

    Parameters
    ----------
    pad
        The pad.

    Returns
    -------
    mujoco.MjSpec
        The arm with the site "pad" in the middle of the foam's surface, z outwards. A rigid plate
        lies where the foam is solid. The foam itself collides with nothing.
    """
    mujoco = import_mujoco()
    o = pad or PadOptions()
    spec = mujoco.MjSpec.from_file(str(LBR_ARM))
    _set_options(mujoco, spec)
    flange = spec.site(TOOL_SITE)
    body = flange.parent.add_body(name=PAD_BODY)
    body.pos = np.add(flange.pos, [0.0, 0.0, PAD_STANDOFF])
    body.gravcomp = 1
    body.add_site(name=PAD_SITE, size=[0.004] * 3, group=4)
    half = 0.5 * o.pitch * np.array([o.columns, o.rows])
    thick = 0.5 * (PAD_STANDOFF - o.foam.hard_depth)
    plate = body.add_geom(name="pad_plate", type=mujoco.mjtGeom.mjGEOM_BOX)
    plate.size = [*(half + _PLATE_MARGIN), thick]
    plate.pos = [0.0, 0.0, -o.foam.hard_depth - thick]
    plate.mass, plate.rgba = _PAD_MASS, _PLATE_COLOUR
    foam = body.add_geom(name="pad_foam", type=mujoco.mjtGeom.mjGEOM_BOX)
    foam.size = [*half, 0.5 * o.foam.thickness]
    foam.pos = [0.0, 0.0, -0.5 * o.foam.thickness]
    foam.mass, foam.contype, foam.conaffinity, foam.group = 0.0, 0, 0, 1
    foam.rgba = _FOAM_COLOUR
    return spec


def _set_options(mujoco: Any, spec: Any) -> None:
    spec.option.timestep = 1.0 / IMAGE_RATE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # Held and resting objects creep less with elliptic cones and a high impratio.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _IMPRATIO


def _cell(mujoco: Any, arms: tuple[Arm, ...], pad: PadOptions) -> Any:
    if len(arms) == 1 and not arms[0].prefix:
        spec = padded_arm(pad)
        _set_pose(spec.body(_BASE_BODY), arms[0].T_world_base)
        return spec
    spec = mujoco.MjSpec()
    _set_options(mujoco, spec)
    for arm in arms:
        stand = spec.worldbody.add_frame()
        _set_pose(stand, arm.T_world_base)
        spec.attach(padded_arm(pad), prefix=arm.prefix, frame=stand)
    return spec


def _set_pose(item: Any, pose: RigidTransform) -> None:
    item.pos = pose.translation
    item.quat = pose.rotation.as_quat(scalar_first=True)


def _add_object(spec: Any, item: PlacedObject) -> dict[str, Foam]:
    touched = item.touch_object
    body = spec.worldbody.add_body(name=touched.name, mocap=item.motion == "mocap")
    _set_pose(body, item.T_world_object)
    if item.motion == "free":
        body.add_freejoint()
    bits = _SOFT_BIT if touched.foam else _RIGID_BIT | _SOFT_BIT
    return touched.add_geoms(body, item.mass, bits)

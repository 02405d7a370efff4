"""Scenes for touch: one arm or two with a tactile pad as fingertip, and objects in the cell."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..arms import LBR_ARM, TOOL_SITE
from ..mujoco_import import import_mujoco
from .tactile_pad import IMAGE_RATE, PAD_SITE, PadOptions

if TYPE_CHECKING:
    from .foam import Foam
    from .touch_objects import TouchObject

PAD_BODY = "pad"
"""Name of the body that carries the pad."""
PAD_STANDOFF = 0.04
"""From the arm's flange to the foam's surface, m: the pad's plate and electronics."""
RIGID_BIT, SOFT_BIT = 1, 2
"""Who collides by MuJoCo's own contact: the pad's plate and arms with what is rigid alone, as the
give of soft objects is in the bed; all objects with one another and the table."""

_PLATE_MARGIN = 0.002
_PAD_MASS = 0.25
_FOAM_COLOUR = (0.16, 0.17, 0.19, 1.0)
_PLATE_COLOUR = (0.75, 0.77, 0.8, 1.0)
_OBJECT_COLOUR = (0.72, 0.42, 0.2, 1.0)
_BASE_BODY = "base"
_IMPRATIO = 100.0


@dataclass(frozen=True)
class PlacedObject:
    """An object in the cell.

    Raises
    ------
    InputError
        If a free object has no mass.
    """

    thing: TouchObject
    """What it is."""
    T_world_object: RigidTransform = field(default_factory=RigidTransform.identity)
    """Maps its coordinates to the world's."""
    motion: str = "fixed"
    """"fixed", "free" (falls and is pushed) or "mocap" (its place is set from outside)."""
    mass: float = 0.1
    """kg, of a free object."""

    def __post_init__(self) -> None:
        if self.motion not in ("fixed", "free", "mocap"):
            raise InputError(f"motion must be fixed, free or mocap, got {self.motion!r}")
        if self.motion == "free" and not 0 < self.mass < np.inf:
            raise InputError(f"a free object's mass must be > 0 kg, got {self.mass}")


@dataclass(frozen=True)
class Arm:
    """An arm with a pad in the cell."""

    T_world_base: RigidTransform = field(default_factory=RigidTransform.identity)
    """Where it stands."""
    prefix: str = ""
    """Goes before the names of its bodies, joints and site ("left_joint1"); of several arms each
    needs one."""


@dataclass(frozen=True)
class PadScene:
    """A compiled cell."""

    model: Any
    """``mujoco.MjModel``."""
    sites: tuple[str, ...]
    """The pads' sites, one per arm."""
    joints: tuple[tuple[str, ...], ...]
    """Names of each arm's joints, from the base up."""
    softness: dict[str, Foam]
    """Names of the geoms that are not rigid, and what they are made of."""
    pad: PadOptions
    """What the pads are like."""


def pad_scene(
    objects: tuple[PlacedObject, ...] = (),
    arms: tuple[Arm, ...] = (Arm(),),
    pad: PadOptions | None = None,
) -> PadScene:
    """Build a cell.

    Parameters
    ----------
    objects
        What there is to touch. Names must differ.
    arms
        One or more; prefixes must differ.
    pad
        The same for every arm.

    Returns
    -------
    PadScene
        The model's time step is that of the pad's images, and its integrator `implicitfast`.

    Raises
    ------
    InputError
        If two names or prefixes are the same.
    DeviceError
        If MuJoCo cannot be loaded.
    """
    mujoco = import_mujoco()
    options = pad or PadOptions()
    names = [item.thing.name for item in objects]
    prefixes = [arm.prefix for arm in arms]
    for what, given in (("objects", names), ("arms", prefixes)):
        if len(set(given)) < len(given):
            raise InputError(f"names of {what} must differ, got {given}")
    if len(arms) > 1 and "" in prefixes:
        raise InputError(f"each of several arms needs a prefix, got {prefixes}")
    spec = _cell(mujoco, arms, options)
    softness: dict[str, Foam] = {}
    for item in objects:
        softness.update(_add_object(mujoco, spec, item))
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
    """Give the arm with a pad at its flange, as a spec that a robot model can be read from.

    Parameters
    ----------
    pad
        The pad.

    Returns
    -------
    mujoco.MjSpec
        With the site "pad" in the middle of the foam's surface, z outwards. The plate that stops
        what bottoms out lies where the foam is solid; the foam itself collides with nothing.
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
    # Held and resting objects creep less with elliptic cones and a high ratio.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _IMPRATIO


def _cell(mujoco: Any, arms: tuple[Arm, ...], pad: PadOptions) -> Any:
    if len(arms) == 1 and not arms[0].prefix:
        spec = padded_arm(pad)
        _put(spec.body(_BASE_BODY), arms[0].T_world_base)
        return spec
    spec = mujoco.MjSpec()
    _set_options(mujoco, spec)
    for arm in arms:
        stand = spec.worldbody.add_frame()
        _put(stand, arm.T_world_base)
        spec.attach(padded_arm(pad), prefix=arm.prefix, frame=stand)
    return spec


def _put(item: Any, pose: RigidTransform) -> None:
    item.pos = pose.translation
    item.quat = pose.rotation.as_quat(scalar_first=True)


def _add_object(mujoco: Any, spec: Any, item: PlacedObject) -> dict[str, Foam]:
    thing = item.thing
    body = spec.worldbody.add_body(name=thing.name, mocap=item.motion == "mocap")
    _put(body, item.T_world_object)
    if item.motion == "free":
        body.add_freejoint()
    bits = SOFT_BIT if thing.foam else RIGID_BIT | SOFT_BIT
    named: dict[str, Foam] = {}
    for number, part in enumerate(thing.parts):
        name = f"{thing.name}_{number}"
        geom = body.add_geom(name=name, type=getattr(mujoco.mjtGeom, f"mjGEOM_{part.kind.upper()}"))
        geom.size[: len(part.size)] = part.size
        geom.pos, geom.quat = part.place, part.quat_wxyz
        geom.contype = geom.conaffinity = bits
        geom.mass = item.mass / len(thing.parts)
        geom.rgba = _OBJECT_COLOUR
        if thing.foam:
            named[name] = thing.foam
    return named

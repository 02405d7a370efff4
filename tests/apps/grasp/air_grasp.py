"""A hand fixed in the air closes on a solid held before it, and is left alone with it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import (
    SynergyDrives,
    find_frame,
    grip_pads,
    match_options,
    synergy_hand_model,
)
from eyehand.data_synth.scenes import Table, TabletopObject
from eyehand.data_synth.scenes.tabletop_spec import tabletop_spec
from eyehand.errors import InputError
from eyehand.grasping import Closing, GripOptions, preshape_command
from eyehand.grasping.hands import finger_forces

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.data_synth.cell import HandDescription
    from eyehand.grasping import HandModel, Prototype
    from eyehand.perception.superquadric import Superquadric

STEP_S, CONTROL_STEPS = 0.002, 2
"""Physics step, and steps in a control period."""
HEIGHT_M = 1.0
"""Of the palm over the floor: what is let go falls far."""
PREFIX = "hand/"
TIP_OVERLAP_M = 0.012
"""How far tips reach past the middle of what they hold."""
PALM_GAP_M = 0.002
"""Palm to solid where the whole hand closes around it."""
CLEARANCE_M = 0.03
"""Opening beyond the solid's width."""
PRESHAPE_S, CLOSE_S = 0.8, 5.0
"""Longest times."""
FELT_N = 0.1
"""Force that counts as touch."""
LOST_MM = 20.0
"""What has moved farther in the hand, mm, was not held."""
SUPPORT = "support"
"""Name of the weld that holds the solid until the hand does."""

COLOUR = (0.85, 0.45, 0.15)
"""Of the solid, RGB."""

Facing = Literal["down", "side"]
"""Where the palm looks."""

_TURNS = {
    "down": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    "side": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
}
"""T_world_hand's rotation."""


@dataclass(frozen=True)
class AirGrasp:
    """How it went; true in a condition when the solid stayed in the hand."""

    state: str
    """Of the closing, when the support was taken away."""
    fingers: int
    """Fingers that felt the solid at the end, without the thumb."""
    thumb: bool
    """Whether the thumb, or the palm in its place, did."""
    pads: int
    """Pads in contact at the end."""
    moved_mm: float
    """Way of the solid from when it was let go to the end, mm: fingers and thumb, held apart by its
    support before, find their balance."""
    creep_mm: float
    """The same in the last half of that time, mm."""
    warnings: int
    """Physics warnings."""

    def __bool__(self) -> bool:
        held = self.fingers > 0 and self.thumb and self.moved_mm < LOST_MM
        return held and self.state == "holding"


def grasp_in_air(
    spec: Any,
    description: HandDescription,
    frame: str,
    shape: Superquadric,
    mass: float,
    prototype: Prototype,
    *,
    facing: Facing = "down",
    friction: float = 1.0,
    hold: float = 1.0,
    watch: Callable[[Any, Any], None] | None = None,
) -> AirGrasp:
    """Close a hand of joints on a solid, take the solid's support away, and wait.

    Parameters
    ----------
    spec
        `MjSpec` of the hand alone; not changed.
    description
        How its fingers close.
    frame
        Its hand frame.
    shape
        The solid; it is held upright, closed upon along its x-axis: its pose is not looked at.
    mass
        Its mass, kg.
    prototype
        How to grasp.
    facing
        Where the palm looks.
    friction
        Of the hand's pads.
    hold
        How long the hand is left alone with it, s.
    watch
        Called with model and data after every control period (for pictures).

    Raises
    ------
    InputError
        If the hand and its description do not fit one another, or the solid is too wide.
    """
    mujoco = import_mujoco()
    spec = spec.copy()
    alone = spec.compile()
    hand = synergy_hand_model(alone, description, frame)
    along = {"down": [0.0, 0.0, 1.0], "side": [0.0, 1.0, 0.0]}[facing]
    width = 2.0 * _half(shape, [1.0, 0.0, 0.0])
    if width > hand.max_opening:
        raise InputError(
            f"the solid is {1e3 * width:.0f} mm wide, "
            f"the hand opens to {1e3 * hand.max_opening:.0f} mm"
        )
    opening = min(width + CLEARANCE_M, hand.max_opening)
    T_world_hand = RigidTransform.from_components(
        [0.0, 0.0, HEIGHT_M], Rotation.from_matrix(np.array(_TURNS[facing], dtype=float))
    )
    ahead = _depth(hand, prototype, _half(shape, along), width, opening)
    pose = RigidTransform.from_translation(T_world_hand.apply([0.0, 0.0, ahead]))
    solid = TabletopObject("solid", replace(shape, pose=pose), mass, COLOUR)
    model = _world(spec, description, solid, T_world_hand * _root(alone, frame), friction)
    data = mujoco.MjData(model)
    drives = SynergyDrives(model, data, description, prefix=PREFIX)
    drives.pose(hand.excursions_at(opening))
    mujoco.mj_forward(model, data)
    body = model.body("solid").id
    period = STEP_S * CONTROL_STEPS

    def step(command: Any) -> Any:
        drives.command(command)
        for _ in range(CONTROL_STEPS):
            drives.apply()
            mujoco.mj_step(model, data)
        if watch is not None:
            watch(model, data)
        return drives.reading()

    reading = drives.reading()
    for _ in range(int(PRESHAPE_S / period)):
        reading = step(preshape_command(hand, opening, prototype))
    closing = Closing(hand, prototype, opening, GripOptions())
    for _ in range(int(CLOSE_S / period)):
        if closing.state in ("holding", "empty"):
            break
        reading = step(closing.step(reading, period))
    state = closing.state
    data.eq_active[model.equality(SUPPORT).id] = 0
    start = half = data.xpos[body].copy()
    count = int(hold / period)
    for k in range(count):
        reading = step(closing.step(reading, period))
        half = data.xpos[body].copy() if k == count // 2 else half
    forces = finger_forces(reading, hand)
    return AirGrasp(
        state=state,
        fingers=int((forces[:-1] > FELT_N).sum()),
        thumb=bool(max(forces[-1], reading.forces[-1]) > FELT_N),
        pads=int((reading.forces > FELT_N).sum()),
        moved_mm=1e3 * float(np.linalg.norm(data.xpos[body] - start)),
        creep_mm=1e3 * float(np.linalg.norm(data.xpos[body] - half)),
        warnings=int(sum(data.warning.number)),
    )


def _depth(hand: HandModel, prototype: Prototype, half: float, width: float, opening: float) -> Any:
    """Distance of the solid's middle from the palm, m."""
    near = half + PALM_GAP_M
    if prototype == "power":
        return near
    reach = min(hand.reach(width), hand.reach(opening))
    return max(near, reach - TIP_OVERLAP_M)


def _half(shape: Superquadric, axis: list[float]) -> float:
    """Half extent of a solid along an axis of its own, m."""
    upright = replace(shape, pose=RigidTransform.identity())
    return float(upright.support(np.array(axis)))


def _root(model: Any, frame: str) -> RigidTransform:
    """T_hand_root of a hand alone, its joints at 0."""
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    body, site = find_frame(model, frame)
    place = data.site_xpos[site] if site >= 0 else data.xpos[body]
    turn = data.site_xmat[site] if site >= 0 else data.xmat[body]
    rotation = Rotation.from_matrix(turn.reshape(3, 3))
    return RigidTransform.from_components(place, rotation).inv()


def _world(
    hand: Any,
    description: HandDescription,
    solid: TabletopObject,
    T_world_root: RigidTransform,
    friction: float,
) -> Any:
    mujoco = import_mujoco()
    world = tabletop_spec([solid], Table(), free=True)
    option = world.option
    option.timestep, option.impratio = STEP_S, 100
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone, option.solver = mujoco.mjtCone.mjCONE_ELLIPTIC, mujoco.mjtSolver.mjSOL_NEWTON
    match_options(world, hand)
    grip_pads(hand, description, friction)
    place = world.worldbody.add_frame(
        pos=T_world_root.translation, quat=T_world_root.rotation.as_quat(scalar_first=True)
    )
    world.attach(hand, frame=place, prefix=PREFIX)
    weld = world.add_equality(name=SUPPORT, type=mujoco.mjtEq.mjEQ_WELD)
    # The point in the world that is welded; no pose of its own, so the one in which the world
    # begins; as stiff in turning.
    weld.data[:11] = [*solid.shape.centre, *np.zeros(7), 1.0]
    weld.objtype, weld.name1 = mujoco.mjtObj.mjOBJ_BODY, "solid"
    return world.compile()

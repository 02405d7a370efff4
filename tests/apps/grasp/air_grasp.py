"""Simulate a hand fixed in the air that closes on a solid and holds it without support."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell import match_options
from eyehand.data_synth.cell.hand_frame import find_frame
from eyehand.data_synth.cell.pad_friction import grip_pads
from eyehand.data_synth.cell.synergy_drives import SynergyDrives
from eyehand.data_synth.cell.synergy_hand_model import synergy_hand_model
from eyehand.data_synth.scenes import Table, TabletopObject
from eyehand.data_synth.scenes.tabletop_spec import tabletop_spec
from eyehand.errors import InputError
from eyehand.grasping.hands import GripOptions
from eyehand.grasping.hands.closing import Closing, preshape_command
from eyehand.grasping.hands.hand_state import finger_forces

if TYPE_CHECKING:
    from collections.abc import Callable

    from eyehand.data_synth.cell import HandDescription
    from eyehand.grasping import HandModel, Prototype
    from eyehand.perception.superquadric import Superquadric

STEP_S, CONTROL_STEPS = 0.002, 2
"""Physics step, s, and number of physics steps per control period."""
HEIGHT_M = 1.0
"""Height of the palm above the floor, m. A lost solid falls far."""
PREFIX = "hand/"
TIP_OVERLAP_M = 0.012
"""Distance by which the fingertips reach past the middle of the solid, m."""
PALM_GAP_M = 0.002
"""Gap between palm and solid in a power grasp, m."""
CLEARANCE_M = 0.03
"""Opening of the hand beyond the solid's width, m."""
PRESHAPE_S, CLOSE_S = 0.8, 5.0
"""Maximum times of the preshape and of the closing, s."""
TOUCH_FORCE_N = 0.1
"""Force that counts as touch."""
MAX_MOTION_MM = 20.0
"""Maximum motion of a held solid in the hand, mm."""
SUPPORT = "support"
"""Name of the weld that holds the solid until the hand has closed."""

COLOUR = (0.85, 0.45, 0.15)
"""Colour of the solid, RGB."""

Facing = Literal["down", "side"]
"""Direction of the palm."""

_ROTATIONS = {
    "down": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
    "side": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
}
"""Rotation of T_world_hand for each direction of the palm."""


@dataclass(frozen=True)
class AirGrasp:
    """The result of a grasp. It is true in a condition if the solid stayed in the hand."""

    state: str
    """State of the closing when the support was removed."""
    fingers: int
    """Number of fingers in contact at the end, without the thumb."""
    thumb: bool
    """Whether the thumb or the palm was in contact at the end."""
    pads: int
    """Number of pads in contact at the end."""
    moved_mm: float
    """Motion of the solid after the support was removed, mm. Fingers and thumb come to a balance,
    which the support prevented before."""
    creep_mm: float
    """Motion of the solid in the second half of that time, mm."""
    warnings: int
    """Number of physics warnings."""

    def __bool__(self) -> bool:
        held = self.fingers > 0 and self.thumb and self.moved_mm < MAX_MOTION_MM
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
    on_cycle: Callable[[Any, Any], None] | None = None,
) -> AirGrasp:
    """Close a hand with driven joints on a solid, remove the support of the solid, and wait.

    Parameters
    ----------
    spec
        `MjSpec` of the hand alone. It is not changed.
    description
        Description of the closing fingers.
    frame
        Name of the hand frame.
    shape
        The solid. It stands upright and the hand closes along its x axis. Its pose is ignored.
    mass
        Mass of the solid, kg.
    prototype
        Prototype of the grasp.
    facing
        Direction of the palm.
    friction
        Friction coefficient of the hand's pads.
    hold
        Time after the support is removed, s.
    on_cycle
        Callback after every control period, with model and data.

    Raises
    ------
    InputError
        If the description does not fit the hand, or the solid is too wide.
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
        [0.0, 0.0, HEIGHT_M], Rotation.from_matrix(np.array(_ROTATIONS[facing], dtype=float))
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
        if on_cycle is not None:
            on_cycle(model, data)
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
        fingers=int((forces[:-1] > TOUCH_FORCE_N).sum()),
        thumb=bool(max(forces[-1], reading.forces[-1]) > TOUCH_FORCE_N),
        pads=int((reading.forces > TOUCH_FORCE_N).sum()),
        moved_mm=1e3 * float(np.linalg.norm(data.xpos[body] - start)),
        creep_mm=1e3 * float(np.linalg.norm(data.xpos[body] - half)),
        warnings=int(sum(data.warning.number)),
    )


def _depth(hand: HandModel, prototype: Prototype, half: float, width: float, opening: float) -> Any:
    """Return the distance of the solid's centre from the palm, m."""
    near = half + PALM_GAP_M
    if prototype == "power":
        return near
    reach = min(hand.reach(width), hand.reach(opening))
    return max(near, reach - TIP_OVERLAP_M)


def _half(shape: Superquadric, axis: list[float]) -> float:
    """Return half the extent of a solid along one of its own axes, m."""
    upright = replace(shape, pose=RigidTransform.identity())
    return float(upright.support(np.array(axis)))


def _root(model: Any, frame: str) -> RigidTransform:
    """Return T_hand_root of a hand with all joints at 0."""
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
    # Anchor point, zero relative pose (the initial pose applies), equal rotational stiffness.
    weld.data[:11] = [*solid.shape.centre, *np.zeros(7), 1.0]
    weld.objtype, weld.name1 = mujoco.mjtObj.mjOBJ_BODY, "solid"
    return world.compile()

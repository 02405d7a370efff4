"""A test bench for the hand on linear rails: close on one solid, lift, hold and shake."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.tendon_drives import PALM_PAD, TendonDrives
from eyehand.data_synth.cell.tendon_hand_model import HAND, tendon_hand_model
from eyehand.data_synth.scenes import Table, TabletopObject
from eyehand.data_synth.scenes.tabletop_spec import tabletop_spec
from eyehand.grasping.hands import GripOptions
from eyehand.grasping.hands.closing import Closing, preshape_command
from eyehand.grasping.hands.hand_state import finger_curl, finger_forces
from eyehand.grasping.prototypes import Approach, Prototype

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.grasping.hands import HandCommand, HandModel, HandReading

STEP_S = 0.002
CONTROL_STEPS = 2
"""Physics steps per control period of 4 ms, as in the simulated robot."""
RAIL_STIFFNESS = 4e4
RAIL_DAMPING = 1.2e3
"""Stiffness, N/m, and damping, Ns/m, of the rails: 0.6 kg deflects them by 0.15 mm."""
SETTLE_S = 0.1
"""Time before slip is measured, s. The rail stops abruptly after the lift and shakes the object."""
FINGERTIP_CLEARANCE = 0.004
"""Height of the fingertips above the table, m."""
TIP_BELOW_CENTRE = 0.012
"""Depth of the fingertips below the object's centre in a precision grasp, m."""
PALM_GAP = 0.002
"""Distance from the palm to the object in a power grasp, m."""
TOUCH_GAP = 0.001
"""Minimum distance of the palm from the object in a side grasp, m."""
CONTACT_FORCE = 0.05
"""Pad force above which a pad is in contact, N."""
PALM_WIDTH, FLAT_GAP_SLOPE = 0.058, 0.85
"""Free width between the roots of fingers and thumb, m, and the gap per metre of a wider flat face.
Such a face touches the opened fingers before it touches the palm."""
ROUND_EXPONENT = 0.3
"""Superquadric exponent below which a face is flat. The first exponent describes the ends, the
second the sides."""


@dataclass(frozen=True)
class HandBenchOptions:
    """Options of a bench grasp."""

    friction: float = 1.0
    """Friction coefficient between the pads and the object."""
    clearance: float = 0.03
    """Opening minus the object's width, m: 10 mm of position error on each side, and a reserve."""
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Error of the estimated position, m."""
    turn: float = 0.0
    """Error of the estimated yaw, rad."""
    scale: float = 1.0
    """Ratio of the estimated size to the true size."""
    lift: float = 0.15
    """Height of the lift, m."""
    hold: float = 1.0
    """Duration of the hold after the lift, s."""
    shake: float = 0.0
    """Duration of the shaking after the hold, s: 10 mm at 3 Hz along all axes."""
    grip: GripOptions = field(default_factory=GripOptions)
    """Options of the grip."""


@dataclass(frozen=True)
class BenchResult:
    """The result of a bench grasp. It is true if the hand still holds the object at the end."""

    success: bool
    """Whether the object was lifted with the hand, within 2 cm, and held until the end."""
    state: str
    """State of the closing at the start of the lift."""
    contacts: tuple[str, ...]
    """Names of the pads in contact at the end."""
    phalanges: int
    """Number of finger phalanges in contact, without the thumb."""
    thumb: int
    """Number of thumb pads in contact."""
    palm: bool
    """Whether the palm is in contact."""
    curl: float
    """Bend of the fingers around the object, rad."""
    slip_mm: float
    """Motion of the object relative to the palm during the hold, mm."""
    pushed_mm: float
    """Sideways motion of the object before both sides were in contact, mm."""
    force: float
    """Largest force on a pad, N."""
    seconds: float
    """Time from the start of closing to the start of the lift, s."""
    warnings: int
    """Number of physics warnings."""

    def __bool__(self) -> bool:
        return self.success


def bench_grasp(
    item: TabletopObject,
    prototype: Prototype,
    approach: Approach = "top",
    options: HandBenchOptions | None = None,
    *,
    spec: Any = HAND,
    on_cycle: Callable[[Any, Any], None] | None = None,
) -> BenchResult:
    """Grasp one solid at the origin of a table. The hand closes along the world's x-axis.

    Parameters
    ----------
    item
        The object at rest, with its centre above the origin.
    prototype, approach
        The grasp prototype and the approach direction.
    options
        Position errors, friction, lift and grip.
    spec
        The hand as an `MjSpec` or a path.
    on_cycle
        Called with the model and the data after every control period.
    """
    return HandBench(item, prototype, approach, options or HandBenchOptions(), spec, on_cycle).run()


class HandBench:
    """The simulation of one hand and one object."""

    def __init__(
        self,
        item: TabletopObject,
        prototype: Prototype,
        approach: Approach,
        options: HandBenchOptions,
        spec: Any,
        on_cycle: Callable[[Any, Any], None] | None,
    ) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._item, self._options, self._on_cycle = mujoco, item, options, on_cycle
        self._prototype: Prototype = prototype
        self.hand: HandModel = tendon_hand_model(spec)
        half = options.scale * half_extents(item)
        self._opening = min(2.0 * half[0] + options.clearance, self.hand.max_opening)
        flat = item.shape.exponents[approach == "side"] < ROUND_EXPONENT
        self._goal = palm_position(self.hand, prototype, approach, half, self._opening, flat=flat)
        self._goal += options.shift
        if approach == "side":
            # An arm that comes too close, or rotated, stops where the palm touches the object.
            askew = PALM_WIDTH / 2 * abs(np.sin(options.turn))
            self._goal[1] = min(self._goal[1], -half_extents(item)[1] - TOUCH_GAP - askew)
        turn = Rotation.from_euler("z", options.turn)
        axes = {
            "top": [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
            "side": [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        }
        rotation = turn * Rotation.from_matrix(np.array(axes[approach], dtype=float))
        world = tabletop_spec([item], Table(), free=True)
        world.option.timestep, world.option.impratio = STEP_S, 100
        carriage = world.worldbody.add_body(name="carriage", pos=self._goal)
        carriage.gravcomp = 1.0
        carriage.quat = rotation.as_quat(scalar_first=True)
        for name, axis in zip("xyz", np.eye(3), strict=True):
            slide = carriage.add_joint(name=f"rail_{name}", type=mujoco.mjtJoint.mjJNT_SLIDE)
            slide.axis = rotation.inv().apply(axis)
            rail = world.add_actuator(name=f"rail_{name}", target=f"rail_{name}")
            rail.trntype = mujoco.mjtTrn.mjTRN_JOINT
            rail.set_to_position(kp=RAIL_STIFFNESS, kv=RAIL_DAMPING)
        # The extra mass stands for the last links of an arm.
        carriage.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[0.01, 0, 0],
            pos=[0, 0, -0.06],
            mass=3.0,
            contype=0,
            conaffinity=0,
            group=4,
        )
        hand = mujoco.MjSpec.from_file(str(spec)) if not hasattr(spec, "compile") else spec
        world.attach(hand, frame=carriage.add_frame(), prefix="hand/")
        for geom in world.geoms:
            if geom.name.startswith("hand/"):
                geom.friction = [options.friction, *geom.friction[1:]]
        for body in world.bodies:
            if body.name.startswith("hand/"):
                body.gravcomp = 1.0
        self.model = world.compile()
        self.data = mujoco.MjData(self.model)
        self.drives = TendonDrives(self.model, self.data, prefix="hand/", drives=self.hand.drives)
        self._rails = np.array([self.model.actuator(f"rail_{a}").id for a in "xyz"])
        self._site = self.model.site("hand/palm").id
        self._body = self.model.body(item.name).id

    def run(self) -> BenchResult:
        """Pre-shape the hand, then close, lift, hold and shake."""
        options = self._options
        self._start_open()
        closing = Closing(self.hand, self._prototype, self._opening, options.grip)
        start = self.data.xpos[self._body].copy()
        pushed, force, seconds = 0.0, 0.0, 0.0
        period = CONTROL_STEPS * STEP_S
        reading = self.drives.reading()
        while closing.state in ("preshape", "closing", "gripping") and seconds < 5.0:
            reading = self._step(closing.step(reading, period))
            if not closing.touched:
                pushed = float(np.linalg.norm((self.data.xpos[self._body] - start)[:2]))
            seconds += period
        state = closing.state
        if state == "empty":
            return self._result(closing, reading, state, 0.0, pushed, force, seconds)
        rail = np.zeros(3)
        for height in np.arange(0.0, options.lift, 0.25 * period):
            rail[2] = height
            reading = self._step(closing.step(reading, period), rail)
            force = max(force, float(reading.forces.max()))
        for _ in range(int(SETTLE_S / period)):
            reading = self._step(closing.step(reading, period), rail)
        before = self._grip_pose()
        for _ in range(int(options.hold / period)):
            reading = self._step(closing.step(reading, period), rail)
        slip = float(np.linalg.norm(self._grip_pose() - before)) * 1e3
        for k in range(int(options.shake / period)):
            swing = 0.010 * np.sin(2 * np.pi * 3.0 * k * period)
            reading = self._step(closing.step(reading, period), rail + np.full(3, swing))
        return self._result(closing, reading, state, slip, pushed, force, seconds)

    def _start_open(self) -> None:
        """Move the hand to its pre-shape, away from the object."""
        start = np.array([0.0, 0.0, 0.4])
        initial_qpos = self.data.qpos.copy()
        for axis, value in zip("xyz", start, strict=True):
            self.data.joint(f"rail_{axis}").qpos = value
        command = preshape_command(self.hand, self._opening, self._prototype)
        for _ in range(200):
            self._step(command, start, notify=False)
        for axis in "xyz":
            self.data.joint(f"rail_{axis}").qpos = 0.0
            self.data.joint(f"rail_{axis}").qvel = 0.0
        free = self.model.body_jntadr[self._body]
        address = self.model.jnt_qposadr[free]
        self.data.qpos[address : address + 7] = initial_qpos[address : address + 7]
        speed = self.model.jnt_dofadr[free]
        self.data.qvel[speed : speed + 6] = 0.0
        self._mujoco.mj_forward(self.model, self.data)
        self._step(command, np.zeros(3))

    def _step(
        self,
        command: HandCommand,
        rail: NDArray[np.float64] | None = None,
        *,
        notify: bool = True,
    ) -> HandReading:
        self.drives.command(command)
        if rail is not None:
            self.data.ctrl[self._rails] = rail
        for _ in range(CONTROL_STEPS):
            self.drives.apply()
            self._mujoco.mj_step(self.model, self.data)
        if notify and self._on_cycle is not None:
            self._on_cycle(self.model, self.data)
        return self.drives.reading()

    def _grip_pose(self) -> NDArray[np.float64]:
        """Return the object's centre in the hand frame, m."""
        axes = self.data.site_xmat[self._site].reshape(3, 3)
        return axes.T @ (self.data.xpos[self._body] - self.data.site_xpos[self._site])

    def _result(
        self,
        closing: Closing,
        reading: HandReading,
        state: str,
        slip: float,
        pushed: float,
        force: float,
        seconds: float,
    ) -> BenchResult:
        pads = zip(self.hand.pads, reading.forces, strict=True)
        contacts = tuple(pad for pad, force in pads if force > CONTACT_FORCE)
        *fingers, thumb = self.hand.fingers
        risen = self.data.xpos[self._body, 2] - self._item.shape.centre[2]
        return BenchResult(
            success=bool(closing.state == "holding" and risen > self._options.lift - 0.02),
            state=state,
            contacts=contacts,
            phalanges=sum(pad.startswith(tuple(fingers)) for pad in contacts),
            thumb=sum(pad.startswith(thumb) for pad in contacts),
            palm=PALM_PAD in contacts,
            curl=finger_curl(reading, self.hand),
            slip_mm=slip,
            pushed_mm=pushed * 1e3,
            force=max(
                force, float(reading.forces.max()), float(finger_forces(reading, self.hand).max())
            ),
            seconds=seconds,
            warnings=int(sum(self.data.warning.number)),
        )


def palm_position(
    hand: HandModel,
    prototype: Prototype,
    approach: Approach,
    half: NDArray[np.float64],
    opening: float,
    *,
    flat: bool = False,
) -> NDArray[np.float64]:
    """Return the position of the palm face for an object at the origin, (3,), m.

    Parameters
    ----------
    half
        Half extents of the object along x, y, z, (3,), m.
    flat
        Whether the face in front of the palm is as wide as the object.
    """
    height = 2.0 * half[2]
    beyond = max(2.0 * half[0] - PALM_WIDTH, 0.0) if flat else 0.0
    gap = PALM_GAP + FLAT_GAP_SLOPE * beyond
    if approach == "side":
        row = hand.row_width / 2 + FINGERTIP_CLEARANCE
        return np.array([0.0, -(half[1] + gap), max(half[2], row)])
    reach = max(hand.reach(w) for w in np.linspace(2.0 * half[0], opening, 7))
    floor = reach + FINGERTIP_CLEARANCE
    if prototype == "power":
        return np.array([0.0, 0.0, max(floor, height + gap)])
    deep = half[2] + reach - TIP_BELOW_CENTRE
    return np.array([0.0, 0.0, max(floor, height + PALM_GAP, deep)])


def half_extents(item: TabletopObject) -> NDArray[np.float64]:
    """Return the half extents of an object along the world's axes, (3,), m."""
    return np.array([float(item.shape.support(axis)) for axis in np.eye(3)]) - item.shape.centre

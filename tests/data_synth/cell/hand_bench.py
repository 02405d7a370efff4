"""The hand alone on rails: close it on one solid at a known pose, lift, hold, shake."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.data_synth import import_mujoco
from eyehand.data_synth.cell.tendon_drives import PALM_PAD, TendonDrives
from eyehand.data_synth.cell.tendon_hand_model import HAND, tendon_hand_model
from eyehand.data_synth.scenes import Table, TabletopObject, tabletop_spec
from eyehand.grasping.closing import Closing, preshape_command
from eyehand.grasping.grip_options import GripOptions
from eyehand.grasping.hand_state import finger_curl, finger_forces
from eyehand.grasping.prototypes import Approach, Prototype

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.grasping.hand_model import HandModel
    from eyehand.grasping.robot import HandCommand, HandReading

STEP_S = 0.002
CONTROL_STEPS = 2
"""Physics steps in a control period of 4 ms, as the robot runs."""
RAIL_STIFFNESS = 4e4
RAIL_DAMPING = 1.2e3
"""N/m and Ns/m: a stiff arm; 0.6 kg bend it by 0.15 mm."""
SETTLE_S = 0.1
"""After the lift: the rail stops at once, an arm would not, and what that shakes is no creep."""
FINGERTIP_CLEARANCE = 0.004
"""Fingertips over the table, m."""
TIP_BELOW_CENTRE = 0.012
"""How far the tips reach below the middle of what precision holds, m."""
PALM_GAP = 0.002
"""Palm to object in a power grasp, m."""
TOUCH_GAP = 0.001
"""m."""
CONTACT_FORCE = 0.05
"""Force of a pad that counts as contact, N."""
PALM_WIDTH, FLAT_GAP_SLOPE = 0.058, 0.85
"""Free width between the roots of fingers and thumb, m; a flat face wider than that meets the
opened fingers this much before the palm for each metre beyond."""
ROUND_EXPONENT = 0.3
"""Superquadric exponent below which a solid's face is flat: the first for its ends, the second for
its sides."""


@dataclass(frozen=True)
class HandBenchOptions:
    """What is done with the hand."""

    friction: float = 1.0
    """Of the hand's pads on the object."""
    clearance: float = 0.03
    """Opening beyond the object's width, m: 10 mm of error to each side, and something over."""
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the object is taken to be, less where it is, m."""
    turn: float = 0.0
    """The same of its yaw, rad."""
    scale: float = 1.0
    """The same of its size, as a ratio."""
    lift: float = 0.15
    """m."""
    hold: float = 1.0
    """s."""
    shake: float = 0.0
    """Seconds of shaking after the hold: 10 mm at 3 Hz, sideways and up."""
    grip: GripOptions = field(default_factory=GripOptions)
    """Of the closing."""


@dataclass(frozen=True)
class BenchResult:
    """How a grasp went; true in a condition when the object was still in the hand at the end."""

    success: bool
    """Lifted as high as the hand, within 2 cm, and still there at the end."""
    state: str
    """Of the closing, when the lift began."""
    contacts: tuple[str, ...]
    """Names of the pads in contact at the end."""
    phalanges: int
    """How many of them are fingers' phalanges, without the thumb's."""
    thumb: int
    """How many are the thumb's."""
    palm: bool
    """Whether the palm is among them."""
    curl: float
    """How far the fingers bent around, rad."""
    slip_mm: float
    """Object against palm from the end of the lift to the end of the hold, mm."""
    pushed_mm: float
    """How far the object was moved sideways before both sides touched, mm."""
    force: float
    """Largest force of a pad, N."""
    seconds: float
    """From the start of closing to the start of the lift."""
    warnings: int
    """Physics warnings."""

    def __bool__(self) -> bool:
        return self.success


def bench_grasp(
    item: TabletopObject,
    prototype: Prototype,
    approach: Approach = "top",
    options: HandBenchOptions | None = None,
    *,
    spec: Any = HAND,
    watch: Callable[[Any, Any], None] | None = None,
) -> BenchResult:
    """Grasp one solid standing at the origin of a table; the hand closes along world x.

    Parameters
    ----------
    item
        Object at rest, its centre over the origin.
    prototype, approach
        How to grasp.
    options
        Errors, friction, lift.
    spec
        The hand, an `MjSpec` or a path.
    watch
        Called with model and data after every control period (for pictures).
    """
    return HandBench(item, prototype, approach, options or HandBenchOptions(), spec, watch).run()


class HandBench:
    """One hand, one object."""

    def __init__(
        self,
        item: TabletopObject,
        prototype: Prototype,
        approach: Approach,
        options: HandBenchOptions,
        spec: Any,
        watch: Callable[[Any, Any], None] | None,
    ) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._item, self._options, self._watch = mujoco, item, options, watch
        self._prototype: Prototype = prototype
        self.hand: HandModel = tendon_hand_model(spec)
        half = options.scale * half_extents(item)
        self._opening = min(2.0 * half[0] + options.clearance, self.hand.max_opening)
        flat = item.shape.exponents[approach == "side"] < ROUND_EXPONENT
        self._goal = palm_place(self.hand, prototype, approach, half, self._opening, flat=flat)
        self._goal += options.shift
        if approach == "side":
            # An arm that comes too near, or askew, stops where the palm touches.
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
        # A hand weighs more at the end of an arm.
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
        """Pre-shape, close, lift, hold, shake."""
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
        """Let the hand take its pre-shape, away from the object."""
        away = np.array([0.0, 0.0, 0.4])
        place = self.data.qpos.copy()
        for axis, value in zip("xyz", away, strict=True):
            self.data.joint(f"rail_{axis}").qpos = value
        command = preshape_command(self.hand, self._opening, self._prototype)
        for _ in range(200):
            self._step(command, away, watch=False)
        for axis in "xyz":
            self.data.joint(f"rail_{axis}").qpos = 0.0
            self.data.joint(f"rail_{axis}").qvel = 0.0
        free = self.model.body_jntadr[self._body]
        address = self.model.jnt_qposadr[free]
        self.data.qpos[address : address + 7] = place[address : address + 7]
        speed = self.model.jnt_dofadr[free]
        self.data.qvel[speed : speed + 6] = 0.0
        self._mujoco.mj_forward(self.model, self.data)
        self._step(command, np.zeros(3))

    def _step(
        self,
        command: HandCommand,
        rail: NDArray[np.float64] | None = None,
        *,
        watch: bool = True,
    ) -> HandReading:
        self.drives.command(command)
        if rail is not None:
            self.data.ctrl[self._rails] = rail
        for _ in range(CONTROL_STEPS):
            self.drives.apply()
            self._mujoco.mj_step(self.model, self.data)
        if watch and self._watch is not None:
            self._watch(self.model, self.data)
        return self.drives.reading()

    def _grip_pose(self) -> NDArray[np.float64]:
        """Object's centre in the hand frame, m."""
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


def palm_place(
    hand: HandModel,
    prototype: Prototype,
    approach: Approach,
    half: NDArray[np.float64],
    opening: float,
    *,
    flat: bool = False,
) -> NDArray[np.float64]:
    """Place of the palm's face for an object standing at the origin, (3,), m.

    Parameters
    ----------
    half
        Half extents of the object along x, y, z, (3,), m.
    flat
        Whether the face before the palm is as wide as the object.
    """
    height = 2.0 * half[2]
    beyond = max(2.0 * half[0] - PALM_WIDTH, 0.0) if flat else 0.0
    gap = PALM_GAP + FLAT_GAP_SLOPE * beyond
    if approach == "side":
        row = hand.row / 2 + FINGERTIP_CLEARANCE
        return np.array([0.0, -(half[1] + gap), max(half[2], row)])
    reach = max(hand.reach(w) for w in np.linspace(2.0 * half[0], opening, 7))
    floor = reach + FINGERTIP_CLEARANCE
    if prototype == "power":
        return np.array([0.0, 0.0, max(floor, height + gap)])
    deep = half[2] + reach - TIP_BELOW_CENTRE
    return np.array([0.0, 0.0, max(floor, height + PALM_GAP, deep)])


def half_extents(item: TabletopObject) -> NDArray[np.float64]:
    """Half extents of an object along the world's axes, (3,), m."""
    return np.array([float(item.shape.support(axis)) for axis in np.eye(3)]) - item.shape.centre

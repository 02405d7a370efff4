"""A trial of grasp quality as a task: grip beside the best place, improve, lift, load."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth import DepthNoise
from eyehand.data_synth.cell import GraspWorld, SimRobot
from eyehand.grasping import Cell, GraspPlan, HandModel, PickOptions, SelectedGrasp, Tray
from eyehand.grasping.grasp_balance import Balance, balance, felt_centre, slide_controller
from eyehand.grasping.grasp_phases import approach, close, contact, grip, pre_grasp
from eyehand.grasping.hold_quality import PATCH_RADIUS
from eyehand.grasping.pick_state import PickState
from eyehand.grasping.plan import ApproachTask, Score
from eyehand.grasping.shaking import shake
from eyehand.grasping.transport_phases import lift

from .closure_objects import SHAPES, ClosureShape
from .ground_truth_scene import ground_truth_scene

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from eyehand.perception import Scene

METHODS = ("none", "seen", "felt")
"""No task; the task with the centre of mass that a camera estimates; the task with the centre that
the wrist feels when it raises the object by millimetres."""
MAX_OFFSET, MAX_ANGLE = 0.020, np.radians(20.0)
"""Maximum offset of the first grasp along the object, m, and about the vertical, rad."""
MASSES = (0.15, 0.9)
"""Range of the mass, kg."""
SEEN_STD = 0.003
"""Standard deviation of the centre that a camera estimates, m."""
FRICTION = (0.3, 0.9)
"""Range of the sliding friction of the pads."""
TIP_HEIGHT = 0.010
"""Height of the fingertips above the table, m."""
OPENING_MARGIN = 0.03
"""Opening of the hand beyond the width of the object, m."""
LOAD, LOAD_SECONDS, SHAKE_SECONDS = 3.0, 0.4, 1.0
"""Load after the lift as a multiple of the weight, its time, and the time of the shake, s."""
MAX_SLIP = 0.015
"""Motion of the object in the hand from which it counts as lost, m."""
GRAVITY = 9.81
NOTHING = float("nan")
"""Value of a measure that a trial did not reach."""
TIMED_CYCLES = 100
"""Control cycles over which the time of one is measured."""


@dataclass(frozen=True)
class ClosureTrial:
    """One object and one first grasp."""

    shape: ClosureShape
    mass: float
    """Mass, kg."""
    offset: float
    """Offset of the grasp from the centre of mass along the object, m. Of a shape whose density
    varies: from the centre that a camera sees."""
    angle: float
    """Rotation of the hand about the vertical against the object, rad."""
    friction: float
    """Sliding friction of the pads."""
    seen_error: float
    """Error of the centre that a camera estimates, m."""


@dataclass(frozen=True)
class ClosureResult:
    """What one method made of a grasp."""

    gripped: bool = False
    """Whether the hand closed on the object."""
    offset: float = NOTHING
    """Final distance of the opposing axis from the true centre of mass along the row, m."""
    turn: float = NOTHING
    """Final angle between the row of fingers and the object, rad."""
    torque: float = NOTHING
    """Weight times that distance, Nm."""
    margin: float = NOTHING
    """Share of the friction at the pads that weight and torque leave; negative if they slide."""
    tilt: float = NOTHING
    """Rotation of the object in the hand from the grip to the end of the lift, rad; NaN if lost."""
    lifted: bool = False
    """Whether the hand alone holds the object after the lift."""
    kept: bool = False
    """Whether it still holds it after load and shake."""
    seconds: float = 0.0
    """Robot time from the first grip to the last, s."""
    cycle_us: float = NOTHING
    """Computing time of a control cycle of the task, µs; NaN without one."""
    reason: str = ""
    """Why the task ended early; empty otherwise."""


def draw_closure_trial(seed: int) -> ClosureTrial:
    """Draw shape, mass and first grasp."""
    rng = np.random.default_rng((seed, 20))
    return ClosureTrial(
        shape=SHAPES[seed % len(SHAPES)],
        mass=float(np.exp(rng.uniform(*np.log(MASSES)))),
        offset=float(rng.uniform(-MAX_OFFSET, MAX_OFFSET)),
        angle=float(rng.uniform(-MAX_ANGLE, MAX_ANGLE)),
        friction=float(rng.uniform(*FRICTION)),
        seen_error=float(SEEN_STD * rng.standard_normal()),
    )


def run_closure_trial(trial: ClosureTrial, method: str) -> ClosureResult:
    """Grip beside the best place, improve the grasp by a method of `METHODS`, lift and load it."""
    cell, robot = _cell(trial)
    state = _state(trial, robot)
    for phase in (pre_grasp, approach, contact, close):
        if phase(cell, state) is not None:
            return ClosureResult()
    began = cell.reading.time
    found, cycle = _improve(cell, state, trial, method)
    grip(cell, state)
    seconds = cell.reading.time - began
    gripped = _object_in_palm(cell, robot)
    centre = gripped.apply([trial.shape.centre, 0.0, 0.0])
    along = gripped.rotation.apply([1.0, 0.0, 0.0])
    margin = _margin(trial, cell, float(centre[1]))
    lift(cell, state)
    lifted = robot.is_lifted("object")
    tilt = (gripped.rotation.inv() * _object_in_palm(cell, robot).rotation).magnitude()
    if lifted:
        _load(cell, robot, state, trial)
    slid = _object_in_palm(cell, robot).translation - gripped.translation
    kept = robot.is_lifted("object") and float(np.linalg.norm(slid)) < MAX_SLIP
    return ClosureResult(
        gripped=True,
        offset=float(abs(centre[1])),
        turn=float(np.arctan2(abs(along[0]), abs(along[1]))),
        margin=margin,
        torque=trial.mass * GRAVITY * float(abs(centre[1])),
        tilt=float(tilt) if lifted else float("nan"),
        lifted=lifted,
        kept=kept,
        seconds=seconds,
        cycle_us=cycle,
        reason=found.reason if found else "",
    )


def _cell(trial: ClosureTrial) -> tuple[Cell, SimRobot]:
    world = GraspWorld.build([trial.shape.world_object(trial.mass)], friction=trial.friction)
    robot = SimRobot(world, noise=DepthNoise.none())
    place = world.cell
    tray = Tray(np.array(place.tray_centre), place.tray_size, place.tray_height)
    cell = Cell(robot, _sees_nothing, tray, PickOptions())
    cell.wait(0.3)
    cell.begin()
    return cell, robot


def _sees_nothing(frame: object) -> Scene:
    raise NotImplementedError("the trial knows its scene")


def _state(trial: ClosureTrial, robot: SimRobot) -> PickState:
    """Return the pick of a grasp from above, with the offset of the trial."""
    shape = trial.shape
    scene = ground_truth_scene([shape.perceived_object(trial.mass)], np.array([0.0, 0.0, 1.0]))
    down = np.array([0.0, 0.0, -1.0])
    long, across = shape.pose.rotation.as_matrix()[:, :2].T
    thumb = np.cos(trial.angle) * across + np.sin(trial.angle) * long
    point = shape.pose.apply([shape.seen_centre + trial.offset, 0.0, 0.0])
    point[2] = TIP_HEIGHT
    assert isinstance(robot.hand, HandModel)
    reach = robot.hand.reach(shape.width)
    opening = shape.width + OPENING_MARGIN
    tasks = (
        ApproachTask("position", 3, point, down, reach, "tips", retreat_slope=1.0),
        ApproachTask("orientation", 3, point, thumb, 0.0, "palm", palm=down),
    )
    mass = (trial.mass, trial.mass, trial.mass)
    plan = GraspPlan(
        "precision", "top", opening, thumb, down, tasks, Score(1.0, {}), {}, mass, "",
        palm_gap=reach - shape.pieces[0].size[2],
    )  # fmt: skip
    return PickState(SelectedGrasp(scene, scene.objects[0], plan))


def _improve(
    cell: Cell, state: PickState, trial: ClosureTrial, method: str
) -> tuple[Balance | None, float]:
    """Return what the task did, and the computing time of one of its control cycles, µs."""
    if method == "none":
        return None, float("nan")
    palm = cell.palm_pose()
    if method == "felt":
        centre = felt_centre(cell, state)
    else:
        seen = trial.shape.pose.apply([trial.shape.seen_centre + trial.seen_error, 0.0, 0.0])
        centre = float(palm.inv().apply(seen)[1])
    found = balance(cell, state, centre)
    controller = slide_controller(cell, state, cell.palm_pose(), 0.001, 0.01)
    controller.step(cell.reading.q)
    began = time.thread_time()
    for _ in range(TIMED_CYCLES):
        controller.step(cell.reading.q)
    return found, 1e6 * (time.thread_time() - began) / TIMED_CYCLES


def _margin(trial: ClosureTrial, cell: Cell, place: float) -> float:
    """Return the margin to the limit surface of the pads, as `grasping/hold_kernels.py` has it.

    ``place`` is the coordinate of the centre of mass along the row of fingers, m.
    """
    hand = cell.robot.hand
    assert isinstance(hand, HandModel)
    forces, rows = cell.hand.forces(cell.reading.hand)[: len(hand.fingers) - 1], hand.row_offsets
    if forces.sum() <= 0.0:
        return float("nan")
    middle = float(forces @ rows / forces.sum())
    spread = np.sqrt(forces @ (rows - middle) ** 2 / forces.sum() + PATCH_RADIUS**2)
    share = trial.mass * GRAVITY / (2.0 * trial.friction * forces.sum())
    return 1.0 - float(share * np.hypot(1.0, (place - middle) / spread))


def _load(cell: Cell, robot: SimRobot, state: PickState, trial: ClosureTrial) -> None:
    """Pull the held object down, then shake the hand."""
    robot.set_load("object", (LOAD - 1.0) * trial.mass * GRAVITY)
    cell.wait(LOAD_SECONDS, lambda reading: state.grip_command(cell, reading))
    robot.set_load("object", 0.0)
    shake(cell, state, SHAKE_SECONDS)


def _object_in_palm(cell: Cell, robot: SimRobot) -> RigidTransform:
    return cell.palm_pose().inv() * robot.object_pose("object")

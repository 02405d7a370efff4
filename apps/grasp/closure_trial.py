"""A trial of grasp quality as a task: grip beside the best place, improve, lift, load."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, get_args

import numpy as np

from eyehand.data_synth import DepthNoise
from eyehand.data_synth.cell import GraspWorld, SimRobot
from eyehand.grasping import (
    ApproachTask,
    Balancing,
    Cell,
    HandModel,
    PickOptions,
    SelectedGrasp,
    Tray,
    pick_object,
    plan_prototypes,
)

from .bench.held_load import HeldLoad
from .closure_objects import OBJECT, SHAPES, ClosureShape
from .ground_truth_scene import ground_truth_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from eyehand.grasping import CycleInfo, RobotReading
    from eyehand.grasping.hands import AnyCommand
    from eyehand.perception import DepthFrame, Scene

METHODS: tuple[Balancing, ...] = get_args(Balancing)
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
PATCH_RADIUS = 0.006
"""Radius at which the pad of one finger resists turning, m, as in `plan_hold`."""
SETTLE_SECONDS = 0.3
"""Time before the pick in which the object comes to rest, s."""


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


def run_closure_trial(trial: ClosureTrial, method: Balancing) -> ClosureResult:
    """Grip beside the best place, improve the grasp by a method of `METHODS`, lift and load it."""
    world = GraspWorld.build([trial.shape.world_object(trial.mass)], friction=trial.friction)
    robot = _TimedRobot(world, noise=DepthNoise.none())
    place = world.cell
    tray = Tray(np.array(place.tray_centre), place.tray_size, place.tray_height)
    options = PickOptions(balance=method, check_seconds=LOAD_SECONDS, shake_seconds=SHAKE_SECONDS)
    cell = Cell(robot, _sees_nothing, tray, options)
    cell.wait(SETTLE_SECONDS)
    record = _Record(cell, robot, trial)
    cell.on_cycle = record.update
    with suppress(_TrialOver):
        pick_object(cell, _first_grasp(trial, robot))
    return record.result()


class _TrialOver(Exception):  # noqa: N818 - the trial ends, nothing failed
    """The end of a trial. Putting the object down shows nothing."""


class _TimedRobot(SimRobot):
    """A simulated robot that measures the computing time between its steps."""

    left = 0.0
    spent = 0.0
    """Computing time since the step before, s; NaN while the arm rests."""

    def step(
        self, velocity: NDArray[np.float64], command: AnyCommand | None = None
    ) -> RobotReading:
        """Move for one control period."""
        self.spent = time.thread_time() - self.left if np.any(velocity) else NOTHING
        reading = super().step(velocity, command)
        self.left = time.thread_time()
        return reading


class _Record:
    """What happens to the object in a trial."""

    def __init__(self, cell: Cell, robot: _TimedRobot, trial: ClosureTrial) -> None:
        self._cell, self._robot, self._trial = cell, robot, trial
        self._load = HeldLoad(robot, OBJECT, LOAD, trial.friction)
        self._result = ClosureResult()
        self._gripped: RigidTransform | None = None
        self._began = NOTHING
        self._cycles: list[float] = []

    def update(self, cycle: CycleInfo) -> None:
        """Note a control cycle, and set the load for the next one."""
        if cycle.phase == "place":
            self._load.end()
            raise _TrialOver
        self._load.update(cycle)
        if cycle.phase == "grip":
            self._began = np.fmin(self._began, cycle.reading.time)
            self._cycles.append(self._robot.spent)
        elif cycle.phase == "lift" and self._gripped is None:
            self._gripped = self._object_in_palm()
            self._note_grip(self._gripped, cycle)
        elif cycle.phase == "check" and self._gripped is not None:
            held = self._object_in_palm()
            slid = float(np.linalg.norm(held.translation - self._gripped.translation))
            kept = self._robot.is_lifted(OBJECT) and slid < MAX_SLIP
            tilt = self._result.tilt
            if not self._result.lifted:
                tilt = float((self._gripped.rotation.inv() * held.rotation).magnitude())
            self._result = replace(self._result, lifted=self._load.lifted, kept=kept, tilt=tilt)

    def result(self) -> ClosureResult:
        """Return the result."""
        return self._result

    def _note_grip(self, gripped: RigidTransform, cycle: CycleInfo) -> None:
        place = float(gripped.apply([self._trial.shape.centre, 0.0, 0.0])[1])
        along = gripped.rotation.apply([1.0, 0.0, 0.0])
        moving = [spent for spent in self._cycles if np.isfinite(spent)]
        self._result = ClosureResult(
            gripped=True,
            offset=abs(place),
            turn=float(np.arctan2(abs(along[0]), abs(along[1]))),
            torque=self._trial.mass * GRAVITY * abs(place),
            margin=self._margin(place, cycle.force),
            seconds=cycle.reading.time - self._began,
            cycle_us=1e6 * float(np.median(moving)) if moving else NOTHING,
        )

    def _margin(self, place: float, force: NDArray[np.float64]) -> float:
        """Return the margin to the limit surface of the pads, as in `plan_hold`.

        Parameters
        ----------
        place
            Coordinate of the centre of mass along the row of fingers, m.
        force
            Force on each finger, then on the palm, N.
        """
        hand = self._robot.hand
        assert isinstance(hand, HandModel)
        rows = hand.row_offsets
        forces = force[: len(rows)]
        if forces.sum() <= 0.0:
            return NOTHING
        middle = float(forces @ rows / forces.sum())
        spread = np.sqrt(forces @ (rows - middle) ** 2 / forces.sum() + PATCH_RADIUS**2)
        share = self._trial.mass * GRAVITY / (2.0 * self._trial.friction * forces.sum())
        return 1.0 - float(share * np.hypot(1.0, (place - middle) / spread))

    def _object_in_palm(self) -> RigidTransform:
        return self._cell.palm_pose().inv() * self._robot.object_pose(OBJECT)


def _sees_nothing(frame: DepthFrame) -> Scene:
    raise NotImplementedError("the trial knows its scene")


def _first_grasp(trial: ClosureTrial, robot: SimRobot) -> SelectedGrasp:
    """Return a grasp from above, with the offset of the trial."""
    shape, hand = trial.shape, robot.hand
    assert isinstance(hand, HandModel)
    perceived = shape.perceived_object(trial.mass, trial.seen_error)
    scene = ground_truth_scene([perceived], np.array([0.0, 0.0, 1.0]))
    (target,) = scene.objects
    down = np.array([0.0, 0.0, -1.0])
    long, across = shape.pose.rotation.as_matrix()[:, :2].T
    thumb = np.cos(trial.angle) * across + np.sin(trial.angle) * long
    point = shape.pose.apply([shape.seen_centre + trial.offset, 0.0, 0.0])
    point[2] = TIP_HEIGHT
    reach = hand.reach(shape.width)
    tasks = (
        ApproachTask("position", 3, point, down, reach, "tips", retreat_slope=1.0),
        ApproachTask("orientation", 3, point, thumb, 0.0, "palm", palm=down),
    )
    plans = plan_prototypes(target, scene.support, hand=hand)
    plan = replace(
        next(iter(plans)),
        prototype="precision",
        approach="top",
        opening=shape.width + OPENING_MARGIN,
        closing=thumb,
        palm=down,
        tasks=tasks,
        mass=(trial.mass, trial.mass, trial.mass),
        geometry=None,
        palm_gap=reach - shape.pieces[0].size[2],
    )
    return SelectedGrasp(scene, target, plan)

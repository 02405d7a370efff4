"""State of one pick, and the controllers of its motions."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import (
    ApproachController,
    CollisionWorld,
    ControlOptions,
    Obstacle,
    PlannedApproach,
    RobotModel,
)
from eyehand.control.tasks import Orientation, Position, Task

from .hands import ParallelHand
from .hands.closing import Closing
from .held_grip import HeldGrip
from .hold_quality import CONTACT_DEPTH
from .motion import POSITION_SLACK, TURN_SPEED, execute, with_speed, within_slack
from .obstacles import scene_obstacles, solid_obstacle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Scene, SceneObject

    from .cell import Cell
    from .hands import AnyCommand
    from .hands.hand_control import ClosingController
    from .plan import GraspPlan
    from .prototypes import Prototype
    from .report import PickOutcome
    from .robot import RobotReading

TARGET = "target"
"""Name of the target object among the obstacles."""
TRANSIT_SPEED = 1.2
"""Speed of the empty hand far from objects, m/s."""
CARRY_GAIN, CARRY_TURN_SPEED = 8.0, 2.5
"""Gain of the final part of a motion with a held object, 1/s, and angular speed, rad/s. With higher
ones heavy objects leave the grip."""
LIFT_SPEED = 0.35
"""Speed of the lift, of lowering and of moving off an object, m/s."""
LIFT_SECONDS = 2.5
"""Time limit of such a motion, s."""
OPEN_SECONDS, OPENED = 0.25, 0.02
"""Time in which fingers let go, s, and the increase of the width at which a hand has let go, m."""
JAW_SECONDS = 3.0
"""Time limit in which jaws let go, s. Some react late or open slowly."""
MIN_OPENED = 0.002
"""Increase of the width at which jaws have let go after this time, m. Some do not open by their
whole stroke. Encoders are accurate to 1 mm."""
OPEN_READINGS = 5
"""Number of successive readings that must say so where the stroke leaves less than this increase.
One noisy reading can exceed a smaller one."""
GOAL_TOLERANCE = 0.004
"""Error at which a goal far from the object counts as reached, m or rad."""
RETREAT_TOLERANCE = 0.01
"""Error at which a motion away from an object counts as done, m."""
NEAR_TOLERANCE = 0.001
"""Error at which the approach counts as reached, m or rad. An approach always ends this far short
of its goal, on the near side. With 4 mm, fingertips pressed on low round objects above their
middle, and squeezed them out while lifting."""
NEAR_MARGIN = 0.003
"""Distance kept from table and neighbours near the grasp, m. Less reaches lower and closer objects,
but tolerates smaller perception errors."""
NEAR_INFLUENCE = 0.015
"""Distance below which obstacles repel the hand near the grasp, m."""
EMPTY_SECONDS = 0.05
"""Time without an object after which jaws have lost it, s."""
CARRY_PATIENCE = 0.2
"""Time without progress after which a motion with a held object ends, s."""


@dataclass(frozen=True)
class SelectedGrasp:
    """An object to pick and the grasp for it."""

    scene: Scene
    """Perceived scene."""
    target: SceneObject
    """Object to pick, one of the scene."""
    plan: GraspPlan
    """Grasp of the object."""
    perceive_ms: float = 0.0
    """Computing time of perception, ms."""
    plan_ms: float = 0.0
    """Computing time of the selection, ms."""
    firm: bool = False
    """Whether the hand grips with its full force, because the object slipped out before."""


@dataclass(frozen=True)
class PhaseFailure:
    """Failure that ends a pick."""

    outcome: PickOutcome
    """Outcome of the pick."""
    reason: str
    """Reason, in words."""


@dataclass
class PickState:
    """State that the phases of one pick share."""

    grasp: SelectedGrasp
    """Object and grasp."""
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """Offset of the object from its perceived position, estimated by touch, (3,), m."""
    lowering: bool = False
    """Whether the object is being lowered into the tray."""
    closing: ClosingController | None = None
    """Controller of the fingers; None before the hand closes."""
    tare: NDArray[np.float64] | None = None
    """Measurement of the wrist with the empty hand, (6,); None without this sense."""
    held: HeldGrip | None = None
    """Adjusts the grip to the measured load; None without a sense of it."""
    gripped: float | None = None
    """Width of the hand that holds the object, m; None before the grip."""
    held_at: float = -np.inf
    """Robot time at which jaws last held something, s."""
    T_palm_world_at_grasp: RigidTransform = field(default_factory=RigidTransform.identity)
    """Transform from world to palm at the time of the grasp. It maps the perceived pose of the
    object to its pose in the palm while the object is held."""

    @property
    def plan(self) -> GraspPlan:
        """The grasp, shifted by `offset`."""
        plan = self.grasp.plan
        if not self.offset.any():
            return plan
        tasks = tuple(replace(task, point=task.point + self.offset) for task in plan.tasks)
        return replace(plan, tasks=tasks)

    @property
    def prototype(self) -> Prototype:
        """Prototype of the grasp."""
        assert self.grasp.plan.prototype is not None, "a refused grasp cannot be picked"
        return self.grasp.plan.prototype

    def retreat(self, cell: Cell) -> float:
        """Return the distance of the pre-grasp from the grasp, m.

        At the pre-grasp the fingertips are `pre_grasp_distance` away from the object.
        """
        return self.tip_overlap(cell) + cell.options.pre_grasp_distance

    def tip_overlap(self, cell: Cell) -> float:
        """Return the distance by which the fingertips pass the near face of the object, m."""
        plan = self.grasp.plan
        return max(cell.hand.reach(plan.opening) - plan.palm_gap, 0.0)

    def model(self, cell: Cell) -> RobotModel:
        """Return the model of the arm with the hand in the pre-shape of this grasp."""
        return cell.model(cell.hand.posture(self.plan.opening, self.prototype))

    def grip_command(self, cell: Cell, reading: RobotReading) -> AnyCommand | None:
        """Compute the next command of the closing hand; None before it closes."""
        if self.closing is None:
            return None
        if self.held is not None:
            self.held.update(cell, reading)
        return self.closing.step(reading.hand, cell.robot.period)

    def lost(self, cell: Cell) -> str:
        """Return the reason to stop if the closed hand holds nothing any more; empty if it does.

        Fingers are empty only after a while, because a light object bounces between the pads. Jaws
        are after `EMPTY_SECONDS`: a driver may give a single wrong width.
        """
        if isinstance(self.closing, Closing):
            holds = self.closing.state != "empty"
        else:
            if cell.hand.holds(cell.reading.hand):
                self.held_at = cell.reading.time
            holds = cell.reading.time - self.held_at < EMPTY_SECONDS
        return "" if holds else "the object left the hand"

    def follow_load(self, cell: Cell) -> None:
        """Adjust the grip to the load from now on, if hand and wrist measure forces."""
        hand, closing = cell.robot.hand, self.closing
        if self.tare is None or not isinstance(closing, Closing) or isinstance(hand, ParallelHand):
            return
        if cell.options.follow_load:
            reach = hand.reach(cell.hand.width(cell.reading.hand)) - CONTACT_DEPTH
            self.held = HeldGrip(
                closing, self.prototype == "power", hand.row_offsets, self.tare, reach
            )

    def near_goal(
        self,
        cell: Cell,
        tasks: Sequence[Task],
        q: NDArray[np.float64],
        slack: float = POSITION_SLACK,
    ) -> bool:
        """Return whether the errors of tasks at joint angles q (n,) are below ``slack``, m."""
        return within_slack(self.model(cell), tasks, q, slack)

    def world(self, cell: Cell, target: Literal["obstacle", "held", "ignored"]) -> CollisionWorld:
        """Return the collision world of the arm and the scene.

        Parameters
        ----------
        cell
            The robot.
        target
            Role of the target object: an obstacle, a part of the robot, or neither.
        """
        # Far motions avoid the tray and its content as one block. Near motions avoid the walls
        # only, because the hand must reach into the tray. There it avoids what stands in it.
        tray = cell.tray_obstacles if self.lowering else cell.tray.obstacles()
        if target != "ignored" and not self.lowering:
            tray = (cell.tray.as_box(cell.tray_height),)
        obstacles = (*self._scene_obstacles, *tray)
        fit = self.grasp.target.fit
        if target == "ignored" or fit.superquadric is None:
            return CollisionWorld(self.model(cell), obstacles)
        bodies = [
            solid_obstacle(solid, 0.0, f"{TARGET}{number or ''}")
            for number, solid in enumerate(fit.parts or (fit.superquadric,))
        ]
        if target == "obstacle":
            return CollisionWorld(self.model(cell), (*obstacles, *bodies))
        world = CollisionWorld(self.model(cell), obstacles)
        for body in bodies:
            world.attach(body.name, body.shape, self.T_palm_world_at_grasp * body.pose)
        return world

    @cached_property
    def _scene_obstacles(self) -> tuple[Obstacle, ...]:
        grasp = self.grasp
        return scene_obstacles(grasp.scene, grasp.target, may_push=grasp.plan.may_push)

    def transit(
        self, cell: Cell, tasks: Sequence[Task], target: Literal["obstacle", "held"]
    ) -> PlannedApproach:
        """Return a controller with planner for a motion far from the object."""
        speed = cell.options.speed
        if target == "held":
            tasks = _with_carry_speed(cell, tasks)
        else:
            tasks = with_speed(tasks, speed * TRANSIT_SPEED, speed * TURN_SPEED)
        world = self.world(cell, target)
        return PlannedApproach(world, tasks, self.far_options(cell), cell.options.planner)

    def direct_carry(self, cell: Cell, tasks: Sequence[Task]) -> ApproachController:
        """Return a controller without planner for a far motion with the held object."""
        control = replace(self.far_options(cell), retreats=0, patience=CARRY_PATIENCE)
        tasks = _with_carry_speed(cell, tasks)
        return ApproachController(self.world(cell, "held"), tasks, control)

    def near(self, cell: Cell, tasks: Sequence[Task], speed: float) -> ApproachController:
        """Return a controller for a short motion close to table, neighbours or tray.

        ``speed`` is in m/s at the speed factor 1.
        """
        factor = cell.options.speed
        tasks = with_speed(tasks, factor * speed, factor * TURN_SPEED)
        return ApproachController(self.world(cell, "ignored"), tasks, self.near_options(cell))

    def lower(self, cell: Cell, tasks: Sequence[Task]) -> ApproachController:
        """Return a controller that lowers the held object into the tray or onto the table.

        The motion ends early without progress, because the tray's walls may block it.
        """
        factor = cell.options.speed
        control = replace(
            self.near_options(cell), tolerance=RETREAT_TOLERANCE, patience=CARRY_PATIENCE
        )
        tasks = with_speed(tasks, factor * LIFT_SPEED, factor * TURN_SPEED)
        return ApproachController(self.world(cell, "held"), tasks, control)

    def move_off(self, cell: Cell, tasks: Sequence[Task], speed: float) -> ApproachController:
        """Return a controller that moves the hand off what it touches, without obstacles.

        ``speed`` is in m/s at the speed factor 1.
        """
        factor = cell.options.speed
        tasks = with_speed(tasks, factor * speed, factor * TURN_SPEED)
        world = CollisionWorld(self.model(cell), ())
        control = replace(self.near_options(cell), tolerance=RETREAT_TOLERANCE)
        return ApproachController(world, tasks, control)

    def far_options(self, cell: Cell) -> ControlOptions:
        """Return the control options of motions far from the object."""
        return replace(cell.options.control, dt=cell.robot.period, tolerance=GOAL_TOLERANCE)

    def near_options(self, cell: Cell) -> ControlOptions:
        """Return the control options of motions close to the object."""
        return replace(
            self.far_options(cell),
            margin=NEAR_MARGIN,
            influence=NEAR_INFLUENCE,
            retreats=0,
            tolerance=NEAR_TOLERANCE,
        )

    def release(self, cell: Cell, goal: NDArray[np.float64] | None = None) -> PhaseFailure | None:
        """Open the hand and move it off the object; return the failure if jaws do not let go.

        In that case the arm stays.

        Parameters
        ----------
        cell
            The robot.
        goal
            Goal of the palm, (3,), world, m. None moves back against the palm's direction.
        """
        waits = isinstance(cell.robot.hand, ParallelHand) and self.closing is not None
        width = held = cell.hand.width(cell.reading.hand)
        if waits and self.gripped is not None:
            held = min(held, self.gripped)
        opened = held + min(OPENED, 0.5 * max(cell.hand.max_opening - held, 0.0))
        end = cell.reading.time + (JAW_SECONDS if waits else OPEN_SECONDS)
        needed = OPEN_READINGS if waits and held < opened < held + MIN_OPENED else 1
        count = int(width >= opened)
        while count < needed and cell.reading.time < end and not cell.halted:
            cell.step(np.zeros(len(cell.robot.joints)), cell.hand.opened())
            width = cell.hand.width(cell.reading.hand)
            # A width that is not a number counts as narrow.
            count = count + 1 if width >= opened else 0
        let_go = count >= needed or (needed == 1 and width >= held + MIN_OPENED)
        if waits and self.gripped is not None and not let_go and not cell.halted:
            reason = f"it is {1e3 * width:.0f} mm wide after {JAW_SECONDS:g} s"
            return PhaseFailure("hand_stalled", f"the hand does not let go: {reason}")
        palm = cell.palm_pose()
        back = palm.translation - self.retreat(cell) * palm.rotation.as_matrix()[:, 2]
        tasks = (Position(back if goal is None else goal), Orientation(palm.rotation))
        speed = LIFT_SPEED if goal is None else TRANSIT_SPEED
        execute(cell, self.move_off(cell, tasks, speed), cell.options.time_limit(LIFT_SECONDS))
        return None


def _with_carry_speed(cell: Cell, tasks: Sequence[Task]) -> tuple[Task, ...]:
    """Return tasks with the speeds of a hand that carries an object."""
    turn_speed = cell.options.speed * CARRY_TURN_SPEED
    return with_speed(tasks, cell.options.carry_speed, turn_speed, CARRY_GAIN)

"""One pick under way: what was chosen, and what its phases hand on to one another."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.control import ApproachController, CollisionWorld, PlannedApproach
from eyehand.control.tasks import Orientation, Position

from .closing import Closing, open_command, preshape_command
from .motion import go, near_enough, paced
from .obstacles import PUSHING, enclosing, surroundings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.control import ControlOptions, Obstacle, RobotModel
    from eyehand.control.tasks import Task
    from eyehand.perception import Scene, SceneObject

    from .cell import Cell
    from .plan import GraspPlan
    from .prototypes import Prototype
    from .report import PickOutcome

TARGET = "target"
"""Name of the object under way among obstacles."""


@dataclass(frozen=True)
class Choice:
    """What to pick, and how."""

    scene: Scene
    """What was seen."""
    target: SceneObject
    """One of its objects."""
    plan: GraspPlan
    """How to grasp it."""
    perceive_ms: float = 0.0
    """Time that seeing took."""
    plan_ms: float = 0.0
    """Time that choosing took."""


@dataclass(frozen=True)
class Ended:
    """Why a pick ended early."""

    outcome: PickOutcome
    """Which outcome it has."""
    reason: str
    """Why, for people."""


@dataclass
class Job:
    """What the phases of one pick share and hand on."""

    choice: Choice
    """What to pick and how."""
    slot: int
    """Number of its place in the tray."""
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    """How far the object turned out to be from where it was seen, by touch, (3,), m."""
    lowering: bool = False
    """Whether the object is going down into the tray."""
    closing: Closing | None = None
    """The hand's fingers at work, once they close."""
    T_palm_grasped: RigidTransform = field(default_factory=RigidTransform.identity)
    """From the world to the palm at the moment when the object was held: what the hand carries
    moves with it from there."""

    @property
    def plan(self) -> GraspPlan:
        """The grasp, moved to where touch found the object."""
        plan = self.choice.plan
        if not self.offset.any():
            return plan
        tasks = tuple(replace(task, point=task.point + self.offset) for task in plan.tasks)
        return replace(plan, tasks=tasks)

    def back(self, cell: Cell) -> float:
        """How far before the grasp the last way begins, m: with the tips short of the object."""
        plan = self.choice.plan
        return max(cell.robot.hand.reach(plan.opening) - plan.depth, 0.0) + cell.options.before

    @property
    def prototype(self) -> Prototype:
        """How the hand closes."""
        assert self.choice.plan.prototype is not None, "a refusal is not picked"
        return self.choice.plan.prototype

    def model(self, cell: Cell) -> RobotModel:
        """Arm and hand as opened for this grasp, a pincer's other fingers wider."""
        shape = preshape_command(cell.robot.hand, self.plan.opening, self.prototype)
        return cell.model(np.asarray(shape.values))

    def there(self, cell: Cell, tasks: Sequence[Task], q: NDArray[np.float64]) -> bool:
        """Tell whether tasks are met well enough to go on, at joint angles q (n,)."""
        options = cell.options
        return near_enough(self.model(cell), tasks, q, options.slack, options.turn_slack)

    def world(self, cell: Cell, target: Literal["there", "held", "ignored"]) -> CollisionWorld:
        """Give the arm and all that was seen.

        Parameters
        ----------
        cell
            The robot.
        target
            Whether the object to grasp is an obstacle, a part of the robot, or neither.
        """
        # A long way keeps off all that the tray holds; near it, only its walls are known.
        tray = cell.tray.obstacles()
        if target != "ignored" and not self.lowering:
            tray = (cell.tray.filled(cell.tray_height),)
        around = (*self._seen, *tray)
        solid = self.choice.target.fit.superquadric
        if target == "ignored" or solid is None:
            return CollisionWorld(self.model(cell), around)
        itself = enclosing(solid, 0.0, TARGET)
        if target == "there":
            return CollisionWorld(self.model(cell), (*around, itself))
        world = CollisionWorld(self.model(cell), around)
        world.attach(TARGET, itself.shape, self.T_palm_grasped * itself.pose)
        return world

    @cached_property
    def _seen(self) -> tuple[Obstacle, ...]:
        # What fingers may push aside is nothing that they keep far from.
        options = PUSHING if self.choice.plan.may_push else None
        return surroundings(self.choice.scene, self.choice.target, options)

    def far(
        self, cell: Cell, tasks: Sequence[Task], target: Literal["there", "held"]
    ) -> PlannedApproach:
        """Control a long way, among all that was seen."""
        options = cell.options
        speed = options.carry_speed if target == "held" else options.transit_speed
        wanted = paced(tasks, speed, options.transit_turn_speed, options.gain)
        world = self.world(cell, target)
        return PlannedApproach(world, wanted, self.far_options(cell), options.planner)

    def straight(self, cell: Cell, tasks: Sequence[Task]) -> ApproachController:
        """Control a long way with the object in the hand, without a search where it is stuck."""
        options = cell.options
        control = replace(self.far_options(cell), retreats=0, patience=options.down_patience)
        wanted = paced(tasks, options.carry_speed, options.transit_turn_speed, options.gain)
        return ApproachController(self.world(cell, "held"), wanted, control)

    def near(
        self,
        cell: Cell,
        tasks: Sequence[Task],
        speed: float,
    ) -> ApproachController:
        """Control a short way close to table, neighbours or tray."""
        wanted = paced(tasks, speed, cell.options.transit_turn_speed, cell.options.gain)
        return ApproachController(self.world(cell, "ignored"), wanted, self.near_options(cell))

    def down(self, cell: Cell, tasks: Sequence[Task]) -> ApproachController:
        """Control the way down into the tray: about there is there, and walls soon end it."""
        options = cell.options
        control = replace(
            self.near_options(cell), tolerance=options.off, patience=options.down_patience
        )
        wanted = paced(tasks, options.lift_speed, options.transit_turn_speed, options.gain)
        return ApproachController(self.world(cell, "held"), wanted, control)

    def off(self, cell: Cell, tasks: Sequence[Task], speed: float) -> ApproachController:
        """Control a way off what the hand touches, with nothing in the way."""
        wanted = paced(tasks, speed, cell.options.transit_turn_speed, cell.options.gain)
        world = CollisionWorld(self.model(cell), ())
        control = replace(self.near_options(cell), tolerance=cell.options.off)
        return ApproachController(world, wanted, control)

    def far_options(self, cell: Cell) -> ControlOptions:
        """Control options of long ways."""
        options = cell.options
        return replace(options.control, dt=cell.robot.period, tolerance=options.reached)

    def near_options(self, cell: Cell) -> ControlOptions:
        """Control options beside the object."""
        options = cell.options
        return replace(
            options.control,
            dt=cell.robot.period,
            tolerance=options.reached,
            margin=options.near_margin,
            influence=options.near_influence,
            retreats=0,
        )

    def let_go(self, cell: Cell, clear: NDArray[np.float64] | None = None) -> None:
        """Open the hand, and go back off whatever is there.

        Parameters
        ----------
        cell
            The robot.
        clear
            Where the palm goes, (3,), world, m; back along its own way when not given.
        """
        cell.rest(cell.options.open_seconds, open_command(cell.robot.hand))
        palm = cell.palm()
        back = palm.translation - self.back(cell) * palm.rotation.as_matrix()[:, 2]
        tasks = (Position(back if clear is None else clear), Orientation(palm.rotation))
        speed = cell.options.lift_speed if clear is None else cell.options.transit_speed
        go(cell, self.off(cell, tasks, speed), cell.options.lift_seconds)

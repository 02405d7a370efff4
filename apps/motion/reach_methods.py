"""The compared methods: the controller with more and more of its parts, and the baseline mink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from eyehand.control import (
    ApproachController,
    Box,
    CollisionOptions,
    CollisionWorld,
    ControlOptions,
    JointPath,
    Obstacle,
    PlannedApproach,
    PlannerOptions,
)
from eyehand.control.tasks import AxisAlignment, Pose, Position, Task
from eyehand.data_synth import ReachingArm
from eyehand.data_synth.scenes import ReachingObstacle, ReachingScene
from eyehand.errors import InputError

from .arm_choice import reaching_robot
from .reach_outcome import Goal

DEFAULT = "default"
"""The controller with its default options."""
PLANNED = "default + planner"
"""The controller with its default options, and a planner that searches for a path when the
controller is stuck."""
BASELINE = "mink"
"""The library for differential inverse kinematics that the controller is compared with."""
BASELINE_TUNED = "mink tuned"
"""The same library with the retreats of this package's controller and a tuned relaxation."""
BASELINE_PLANNED = "OMPL + IK"
"""Inverse kinematics and RRT-Connect of the library OMPL, with the budget of this package."""
BASELINES = {BASELINE: "mink", BASELINE_TUNED: "mink", BASELINE_PLANNED: "ompl"}
"""Names of the baselines, and the package that each needs."""


class ControllerSettings(NamedTuple):
    """Options of a compared controller."""

    options: ControlOptions
    """Options of the controller."""
    planner: PlannerOptions | None = None
    """Options of the planner; None for no planner."""


CONTROLLERS: dict[str, ControllerSettings] = {
    # Straight to the goal. Avoidance uses only the null space of the goal.
    "null space only": ControllerSettings(ControlOptions(beta=0.0, safety=False, retreats=0)),
    # Avoidance bends the path to the goal at full weight.
    "beta 1": ControllerSettings(ControlOptions(beta=1.0, safety=False, retreats=0)),
    # Avoidance bends the path no more than the goal attracts.
    "dynamic beta": ControllerSettings(ControlOptions(safety=False, retreats=0)),
    # The same with the safety level above it. A stuck motion stays stuck.
    "without retreats": ControllerSettings(ControlOptions(retreats=0)),
    # The dynamic weight, the safety level above it, and retreats.
    DEFAULT: ControllerSettings(ControlOptions()),
    PLANNED: ControllerSettings(ControlOptions(), PlannerOptions()),
}
"""Name → settings of this package's controller, from its barest form to its fullest."""
METHODS: tuple[str, ...] = (*CONTROLLERS, *BASELINES)
"""Names of all methods."""


class ControllerMethod:
    """A controller as a `ReachMethod`, until the controller reports that it is stuck."""

    def __init__(self, controller: ApproachController | PlannedApproach) -> None:
        self._controller = controller
        self.reason = ""
        """Why the last cycle made no progress, or which limits were active; empty if neither."""

    @property
    def paths(self) -> tuple[JointPath, ...]:
        """Results of the planner's searches."""
        return tuple(getattr(self._controller, "paths", ()))

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Return the joint speeds (n,), rad/s, of a cycle and a status; see `ReachMethod`."""
        cycle = self._controller.step(q)
        self.reason = cycle.reason or ", ".join(cycle.blocking[:3])
        return cycle.velocity, "stuck" if cycle.status == "stuck" else ""

    def stop(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the joint speeds (n,), rad/s, of a cycle that brakes."""
        return self._controller.stop(q).velocity


def controller_method(name: str, scene: ReachingScene, goal: Goal = "position") -> ControllerMethod:
    """Return a method of this package, ready for a scene.

    Raises
    ------
    InputError
        If the name is not one of :data:`CONTROLLERS`.
    """
    if name not in CONTROLLERS:
        raise InputError(f"unknown method {name!r}; choose from: {', '.join(METHODS)}")
    options, planner = CONTROLLERS[name]
    world, tasks = reaching_world(scene.obstacles, scene.arm), reaching_tasks(scene, goal)
    if planner is None:
        return ControllerMethod(ApproachController(world, tasks, options))
    return ControllerMethod(PlannedApproach(world, tasks, options, planner))


def reaching_tasks(scene: ReachingScene, goal: Goal) -> tuple[Task, ...]:
    """Return the tasks that reach a goal of a scene."""
    if goal == "position":
        return (Position(scene.goal),)
    if goal == "axis":
        along = AxisAlignment(np.array([0.0, 0.0, 1.0]), scene.goal_axes[:, 2])
        return (Position(scene.goal), along)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = scene.goal_axes, scene.goal
    return (Pose(matrix),)


def reaching_world(
    obstacles: Sequence[ReachingObstacle],
    arm: ReachingArm | None = None,
    options: CollisionOptions | None = None,
) -> CollisionWorld:
    """Return the collision world of an arm, by default the included one, and boxes of a scene."""
    robot = reaching_robot(arm or ReachingArm())
    boxes = [Obstacle(box.name, Box(np.array(box.size)), box.T_world_shape) for box in obstacles]
    return CollisionWorld(robot, boxes, options=options)

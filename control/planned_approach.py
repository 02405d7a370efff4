"""The approach controller with a planner: a stuck robot follows a planned path."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .approach import ApproachController, ControlStep
from .options import ControlOptions
from .planner import plan
from .planner_options import PlannerOptions
from .safety import safe_motion
from .tasks.task import DEFAULT_LINEAR_SPEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .planner import JointPath
    from .robot_model import RobotModel
    from .tasks.task import Task

PATH_TOLERANCE = 0.02
"""Maximum joint error at which a point of the path counts as reached, rad or m."""
SPEED_FRACTION = 0.5
"""Fraction of the joint speed limits that a path uses. The rest is needed to catch up after a
delay."""
MAX_DELAY = 0.5
"""A path is abandoned if the robot does not reach its next point within this time, s."""
ROUNDING = 1e-9
"""Maximum excess over a whole number of cycles that counts as rounding."""


class PlannedApproach:
    """An :class:`ApproachController` that plans and follows a path if it is stuck.

    The safety level is active on the path too. So the robot also stops before obstacles that have
    moved, or that the planner missed because of its longer steps.

    Parameters
    ----------
    world
        The robot and its obstacles.
    tasks
        Highest priority first.
    options
        Options of the controller. The planner does the retreats.
    planner
        Options of the planner.
    searches
        Maximum number of searches before the motion counts as stuck. Several may be needed, because
        a path is abandoned if the safety level blocks it. The count restarts at the goal.

    Raises
    ------
    InputError
        As :class:`ApproachController`.
    """

    def __init__(
        self,
        world: CollisionWorld,
        tasks: Sequence[Task],
        options: ControlOptions | None = None,
        planner: PlannerOptions | None = None,
        *,
        searches: int = 3,
    ) -> None:
        self.options = replace(options or ControlOptions(), retreats=0)
        self.planner = planner or PlannerOptions()
        self.searches = searches
        self.controller = ApproachController(world, tasks, self.options)
        self.restart()

    def restart(self) -> None:
        """Reset paths and progress."""
        self.paths: list[JointPath] = []
        """Results of the searches since the last restart."""
        self._searched = 0
        self._leave_path()

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Return the joint velocities for joint positions q (n,), and advance time by one period.

        A stuck motion stops for one cycle. The next call takes as long as the search.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        if self._at < len(self._track):
            return self._follow(q)
        if self._stuck is not None:
            return self._search(q, self._stuck)
        cycle = self.controller.step(q)
        if cycle.status == "reached":
            self._searched = 0
        if cycle.status != "stuck" or self._searched >= self.searches:
            return cycle
        # A robot keeps its last commanded velocity while the search runs, so that must be zero.
        self._stuck = replace(cycle, velocity=np.zeros_like(cycle.velocity))
        return replace(self._stuck, status="moving", reason="")

    def _search(self, q: NDArray[np.float64], cycle: ControlStep) -> ControlStep:
        """Plan a path from q (n,), where a cycle was stuck."""
        controller = self.controller
        self._stuck = None
        self._searched += 1
        planner = replace(self.planner, seed=self.planner.seed + len(self.paths))
        path = plan(controller.world, controller.tasks, q, self.options, planner)
        self.paths.append(path)
        if not path:
            return replace(cycle, reason=f"{cycle.reason}; no path found: {path.reason}")
        self._track = resample_path(path.configurations, controller.robot, self.options.dt)
        self._at = min(1, len(self._track) - 1)
        return replace(cycle, status="moving", reason="")

    def _follow(self, q: NDArray[np.float64]) -> ControlStep:
        controller, options = self.controller, self.options
        state = controller.robot.at(q)
        proximity = controller.world.proximity(state.q)
        target = self._track[self._at]
        nominal = (target - state.q) / options.dt
        nominal = nominal / max(float(np.max(np.abs(nominal) / state.speed)), 1.0)
        safe = safe_motion(
            nominal, state.jacobian, state, proximity, options, controller.robot.joint_names
        )
        after = state.q + options.dt * safe.velocity
        if np.max(np.abs(target - after)) <= PATH_TOLERANCE:
            self._at, self._delay = self._at + 1, 0.0
        else:
            self._delay += options.dt
        if self._at >= len(self._track) or self._delay > MAX_DELAY:
            self._leave_path()
        errors = tuple(task.at(state).unmet for task in controller.tasks)
        return ControlStep(
            velocity=safe.velocity,
            status="moving" if safe.feasible else "infeasible",
            reason="" if safe.feasible else f"cannot keep the margin: {', '.join(safe.blocking)}",
            phase="path",
            errors=errors,
            clearance=float(proximity.distance.min(initial=float("inf"))),
            beta=(0.0,) * len(errors),
            blocking=safe.blocking,
        )

    def _leave_path(self) -> None:
        self._track = np.zeros((0, self.controller.robot.n))
        self._at = 0
        self._delay = 0.0
        self._stuck: ControlStep | None = None
        self.controller.restart()


def resample_path(
    configurations: NDArray[np.float64], robot: RobotModel, dt: float
) -> NDArray[np.float64]:
    """Resample a path at constant speed: one configuration per cycle, with the first and the last.

    A path consists of several roll-outs, and each slows down towards its end.

    Parameters
    ----------
    configurations
        Joint positions along the path (N, n), rad or m.
    robot
        The robot with its joint speed limits.
    dt
        Control period, s.

    Returns
    -------
    ndarray
        (M, n), linear between the configurations. No step moves the frame faster than the default
        speed of a task, or a joint faster than SPEED_FRACTION of its limit.
    """
    positions = np.array([robot.at(q).position for q in configurations])
    by_frame = np.linalg.norm(np.diff(positions, axis=0), axis=1) / DEFAULT_LINEAR_SPEED
    by_joint = np.max(
        np.abs(np.diff(configurations, axis=0)) / (SPEED_FRACTION * robot.speed), axis=1
    )
    times = np.concatenate([[0.0], np.cumsum(np.maximum(by_frame, by_joint))])
    count = int(np.ceil(times[-1] / dt - ROUNDING)) + 1
    samples = np.minimum(dt * np.arange(count), times[-1])
    return np.column_stack([np.interp(samples, times, column) for column in configurations.T])

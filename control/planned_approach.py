"""The approach controller with a planner: it plans before the motion, and where it is stuck."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .approach import ApproachController, ControlStep, counted
from .cycle import ControlCycle
from .joint_path import JointPath, resample_path
from .joint_planner import find_path
from .options import ControlOptions
from .planner import plan, predict
from .planner_options import PlannerOptions
from .tasks.axis_alignment import AxisAlignment
from .tasks.look_at import LookAt
from .tasks.orientation import Orientation
from .tasks.posture import Posture
from .tasks.task import DEFAULT_LINEAR_SPEED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .collision_world import CollisionWorld
    from .tasks.task import Task

LOOK_AHEAD = 0.12
"""Time on the path between the robot and the point that it heads for, s. A longer one cuts corners
more, and a shorter one swings about the path."""
HAND_OVER = 0.25
"""Time before the end of a path at which the tasks take over, s."""
MAX_DELAY = 0.5
"""A path is abandoned if the robot does not come farther within this time, s."""
DETOUR = 1.3
"""A motion without planning is accepted if it takes at most this factor times the time on a
straight line. Then a search would rarely find a faster one."""
SETTLING = 0.6
"""Time that the tasks need after a path, s."""
OUT_OF_REACH = {False: 0.02, True: 0.15}
"""Error of a task, m, or of an angle, rad, above which a goal counts as unreachable if no
configuration comes nearer. Nearer goals are approached as far as possible."""
LEGS = 8
"""Number of roll-outs of a search before the motion: to the goal and by way of home. More rarely
help as long as the arm is not stuck elsewhere."""


class PlannedApproach:
    """An :class:`ApproachController` that plans and follows paths.

    The first cycle simulates the motion to the tasks. If it gets stuck or takes a detour, a path is
    searched at once, while the robot stands. A goal that no configuration reaches ends the motion
    in this cycle. A motion that gets stuck later brakes and searches again. The safety level is
    active on the path too, so the robot also stops before obstacles that have moved.

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
        # The path itself avoids obstacles, so repulsion would only push the robot off it.
        self._path_options = replace(self.options, eta=0.0, centring=0.0)
        self.restart()

    def restart(self) -> None:
        """Reset paths and progress. The next cycle plans again if the robot stands still."""
        self.paths: list[JointPath] = []
        """Results of the searches since the last restart."""
        self._searched = 0
        self._fresh = True
        self._unreachable = ""
        self._leave_path()

    def step(self, q: NDArray[np.float64]) -> ControlStep:
        """Return the joint velocities for joint positions q (n,), and advance time by one period.

        The first call takes as long as a search, and so does one after the robot was stuck and has
        come to a standstill.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        if self._fresh:
            self._fresh = False
            if self.planner.rollouts and not np.any(self.controller.velocity):
                self._plan_ahead(self.controller.robot.checked(q))
        if self._unreachable:
            return replace(self.controller.stop(q), status="stuck", reason=self._unreachable)
        if self._at < len(self._track):
            return self._follow(q)
        if self._stuck is not None:
            if np.any(self.controller.velocity):
                return self.controller.stop(q)
            return self._search(q, self._stuck)
        cycle = self.controller.step(q)
        if cycle.status == "reached":
            self._searched = 0
        if cycle.status != "stuck" or self._searched >= self.searches:
            return cycle
        # A robot keeps its last commanded velocity while the search runs, so that must be zero.
        self._stuck = cycle
        return replace(cycle, status="moving", reason="")

    def stop(self, q: NDArray[np.float64]) -> ControlStep:
        """Return joint velocities that brake; see :meth:`ApproachController.stop`."""
        self._leave_path()
        return self.controller.stop(q)

    def _plan_ahead(self, q: NDArray[np.float64]) -> None:
        """Choose between the direct motion, a path, and no motion, at the start q (n,)."""
        controller = self.controller
        world, tasks = controller.world, controller.tasks
        state = world.robot.at(q)
        errors = [tasks[k].at(state).unmet for k in counted(tasks)]
        lengths = [e for k, e in zip(counted(tasks), errors, strict=True) if not is_angle(tasks[k])]
        straight = max(lengths, default=0.0) / DEFAULT_LINEAR_SPEED + SETTLING
        reached, seconds = predict(world, tasks, q, self.options, self.planner)
        if reached and seconds <= DETOUR * straight:
            return
        found = find_path(world, tasks, q, self.options, self.planner.seed)
        if found is None:
            return
        state = world.robot.at(found.nearest)
        left = [(tasks[k], tasks[k].at(state).unmet) for k in counted(tasks)]
        if not reached and any(error > OUT_OF_REACH[is_angle(task)] for task, error in left):
            named = ", ".join(f"{task.name} {error:.3g}" for task, error in left)
            at = np.round(state.position, 4).tolist()
            self._unreachable = f"unreachable: at the nearest configuration {named} off, at {at} m"
            return
        path = found.as_joint_path()
        if not path and not reached:
            budget = min(LEGS, self.planner.rollouts)
            path = plan(world, tasks, q, self.options, replace(self.planner, rollouts=budget))
        self.paths.append(path)
        if path and not (reached and seconds < found.seconds + SETTLING):
            self._take(path)

    def _search(self, q: NDArray[np.float64], cycle: ControlStep) -> ControlStep:
        """Plan a path from q (n,), where a cycle was stuck."""
        controller = self.controller
        self._stuck = None
        self._searched += 1
        cycle = replace(cycle, velocity=np.zeros_like(cycle.velocity))
        seed = self.planner.seed + len(self.paths)
        world, tasks = controller.world, controller.tasks
        path = None
        if self.planner.rollouts:
            found = find_path(world, tasks, q, self.options, seed)
            path = None if found is None else found.as_joint_path()
        if not path:
            path = plan(world, tasks, q, self.options, replace(self.planner, seed=seed))
        self.paths.append(path)
        if not path:
            return replace(cycle, reason=f"{cycle.reason}; no path found: {path.reason}")
        self._take(path)
        return replace(cycle, status="moving", reason="")

    def _take(self, path: JointPath) -> None:
        self._track = resample_path(path.configurations, self.controller.robot, self.options.dt)
        self._at = 0

    def _follow(self, q: NDArray[np.float64]) -> ControlStep:
        """Head for the point on the path that lies LOOK_AHEAD before the robot."""
        controller, dt = self.controller, self.options.dt
        q = controller.robot.checked(q)
        ahead = round(LOOK_AHEAD / dt)
        # The nearest point within the next part of the path.
        part = self._track[self._at : self._at + 2 * ahead]
        step = int(np.argmin(np.linalg.norm(part - q, axis=1)))
        self._at += step
        self._delay = 0.0 if step else self._delay + dt
        goal = self._track[min(self._at + ahead, len(self._track) - 1)]
        task = Posture(goal, gain=1.0 / LOOK_AHEAD, speed=1e3)
        motion = ControlCycle(
            controller.world,
            (task,),
            self._path_options,
            controller.tasks,
            frame_speed=DEFAULT_LINEAR_SPEED,
        ).at(q, controller.last_command)
        controller.commit(motion.velocity)
        arrived = len(self._track) - self._at <= HAND_OVER / dt
        if arrived or self._delay > MAX_DELAY:
            self._leave_path()
        errors = motion.errors[1:]
        reason = "" if motion.feasible else f"cannot keep the margin: {', '.join(motion.blocking)}"
        return ControlStep(
            motion.velocity,
            "moving" if motion.feasible else "infeasible",
            reason,
            "path",
            errors,
            motion.clearance,
            (0.0,) * len(errors),
            motion.blocking,
        )

    def _leave_path(self) -> None:
        self._track = np.zeros((0, self.controller.robot.n))
        self._at = 0
        self._delay = 0.0
        self._stuck: ControlStep | None = None
        self.controller.restart()


def is_angle(task: Task) -> bool:
    """Return whether the error of a task is an angle."""
    return isinstance(getattr(task, "task", task), (AxisAlignment, LookAt, Orientation))

"""The approach controller with a planner: it plans before the motion, and where it is stuck."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .approach import ApproachController
from .background import Worker, WorldState
from .collision_world import CollisionWorld
from .control_step import ControlStep, control_step
from .cycle import ControlCycle
from .joint_path import JointPath
from .joint_planner import find_path
from .options import ControlOptions, PlannerOptions
from .search import SearchResult, search_again, search_first
from .tasks.posture import Posture
from .tasks.task import DEFAULT_LINEAR_SPEED, Task

LOOK_AHEAD = 0.12
"""Time on the path between the robot and the point that it heads for, s. A longer one cuts corners
more, and a shorter one swings about the path."""
HAND_OVER = 0.25
"""Time before the end of a path at which the tasks take over, s."""
MIN_SPEED_SHARE = 1.0 / 3.0
"""A robot that is slower than this share of the path's speed is held up by the safety level."""
NEARER_DELAY, MAX_DELAY = 0.1, 0.5
"""Delay of a robot that is held up, s. From the first one it heads for a nearer point, because a
straight line to a distant one cuts the corner that holds it up. The second one ends the path."""


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
    background
        Whether searches run in another thread, for a real control loop. The robot stands while it
        waits, in the phase ``plan``. Without it, every motion can be repeated exactly. It lowers
        Python's switch interval to 0.1 ms.

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
        background: bool = False,
    ) -> None:
        self.options = replace(options or ControlOptions(), retreats=0)
        self.planner = planner or PlannerOptions()
        self.searches = searches
        self.controller = ApproachController(world, tasks, self.options)
        # The path itself avoids obstacles, so repulsion would only push the robot off it.
        self._path_cycle = ControlCycle(
            world,
            (Posture(world.robot.home, gain=1.0 / LOOK_AHEAD, speed=1e3),),
            replace(self.options, eta=0.0, centring=0.0),
            self.controller.tasks,
            frame_speed=DEFAULT_LINEAR_SPEED,
        )
        self._worker = Worker() if background else None
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

        Without ``background``, the first call takes as long as a search, and so does one after the
        robot was stuck and has come to a standstill.

        Raises
        ------
        InputError
            If q has another shape, or is not finite.
        """
        if self._fresh:
            self._fresh = False
            if self.planner.rollouts and not np.any(self.controller.velocity):
                self._begin_search(search_first, self.controller.robot.checked(q))
        if self._stuck is not None and self._result is None:
            if np.any(self.controller.velocity):
                return replace(self.controller.stop(q), status="moving")
            self._searched += 1
            self._begin_search(search_again, self.controller.robot.checked(q))
        if self._result is not None:
            if not self._result.done():
                return replace(self.controller.stop(q), status="moving", phase="plan")
            ended = self._end_search(q)
            if ended is not None:
                return ended
        if self._unreachable:
            return replace(self.controller.stop(q), status="stuck", reason=self._unreachable)
        if self._at < len(self._track):
            return self._follow(q)
        cycle = self.controller.step(q)
        if cycle.status == "reached":
            self._searched = 0
        if cycle.status != "stuck" or self._searched >= self.searches:
            return cycle
        # A robot keeps its last commanded velocity while the search runs, so that must be zero.
        self._stuck = cycle
        return replace(cycle, status="moving", reason="")

    def warm_up(self) -> None:
        """Load all compiled code, so that no later cycle has to; this takes up to a second."""
        controller = self.controller
        controller.warm_up()
        world, q = WorldState(controller.world).make(), controller.robot.home
        search_first(world, controller.tasks, q, self.options, self.planner)
        find_path(world, (Posture(q + 0.05),), q, self.options)
        self._path_cycle.at(q, np.zeros((2, controller.robot.n)))

    def stop(self, q: NDArray[np.float64]) -> ControlStep:
        """Return joint velocities that brake; see :meth:`ApproachController.stop`."""
        self._leave_path()
        return self.controller.stop(q)

    def resume(
        self, velocity: NDArray[np.float64], acceleration: NDArray[np.float64] | None = None
    ) -> None:
        """Continue from another velocity; see :meth:`ApproachController.resume`."""
        self.controller.resume(velocity, acceleration)

    def _begin_search(self, search: Callable[..., SearchResult], q: NDArray[np.float64]) -> None:
        """Search from q (n,), in the background or at once."""
        controller = self.controller
        planner = replace(self.planner, seed=self.planner.seed + len(self.paths))
        arguments = controller.world, controller.tasks, q, self.options, planner
        if self._worker is not None:
            self._result = self._worker.start(search, *arguments)
        else:
            self._result = Future()
            self._result.set_result(search(*arguments))

    def _end_search(self, q: NDArray[np.float64]) -> ControlStep | None:
        """Take the result of a search; return the step where the motion ends with it."""
        assert self._result is not None
        found, self._result = self._result.result(), None
        stuck, self._stuck = self._stuck, None
        if found.path is not None:
            self.paths.append(found.path)
        if found.unreachable:
            self._unreachable = found.unreachable
        if found.track is not None:
            self._track, self._at = found.track, 0
        elif stuck is not None and found.path is not None:
            still = replace(self.controller.stop(q), status="stuck")
            return replace(still, reason=f"{stuck.reason}; no path found: {found.path.reason}")
        return None

    def _follow(self, q: NDArray[np.float64]) -> ControlStep:
        """Head for the point on the path that lies LOOK_AHEAD before the robot, or nearer."""
        controller, dt = self.controller, self.options.dt
        q = controller.robot.checked(q)
        ahead = round(LOOK_AHEAD / dt)
        # The nearest point within the next part of the path.
        part = self._track[self._at : self._at + 2 * ahead]
        step = int(np.argmin(np.linalg.norm(part - q, axis=1)))
        self._at += step
        self._delay = max(0.0, self._delay + dt * (1.0 - step / MIN_SPEED_SHARE))
        if self._delay > NEARER_DELAY:
            ahead = max(1, round(ahead * (1.0 - self._delay / MAX_DELAY)))
        goal = self._track[min(self._at + ahead, len(self._track) - 1)]
        self._path_cycle.head_for(goal)
        motion = self._path_cycle.at(q, controller.last_command)
        controller.commit(motion.velocity)
        arrived = len(self._track) - self._at <= HAND_OVER / dt
        if arrived or self._delay > MAX_DELAY:
            self._leave_path()
        errors = motion.errors[1:]
        reason = "" if motion.feasible else f"cannot keep the margin: {', '.join(motion.blocking)}"
        status = "moving" if motion.feasible else "infeasible"
        return control_step(
            motion._replace(beta=(0.0,) * len(errors)), status, reason, "path", errors
        )

    def _leave_path(self) -> None:
        self._track = np.zeros((0, self.controller.robot.n))
        self._at = 0
        self._delay = 0.0
        self._stuck: ControlStep | None = None
        self._result: Future[SearchResult] | None = None
        self.controller.restart()

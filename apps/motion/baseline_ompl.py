"""The baseline of planned reaching: RRT-Connect of OMPL and inverse kinematics, timed and run."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from eyehand.control import CollisionOptions, JointPath, RobotModel, resample_path
from eyehand.data_synth.scenes import ReachingScene

from .reach_methods import reaching_tasks, reaching_world
from .reach_outcome import Goal

# The budget is that of this package's own search.
SEEDS = 40
"""Number of seeds of the inverse kinematics."""
GOALS = 8
"""Number of goal configurations of a search, those nearest to the start."""
PATHS = 10
"""Number of paths, of which the fastest is executed."""
SEARCHES = 3
"""Number of searches with other seeds before the reach is given up."""
SEARCH_S = 2.0
"""Time limit of one path, s. This package's search takes less for all its paths together."""
MARGIN = 0.010
"""Distance that every configuration of a path must keep, m."""
EXTRA = 0.008
"""Distance beyond the margin away from start and goal, m: smoothing cuts corners."""
NEAR_ENDS = 0.25
"""Joint distance from start and goal within which the margin is enough, rad."""
IK_STEPS = 150
"""Maximum number of steps from a seed."""
IK_ERROR = 1e-5
"""Error at which a configuration reaches the goal, m or rad."""
DAMPING = 1e-3
"""Damping of the steps."""
RESOLUTION = 0.002
"""Distance of two checked configurations, as a share of the joint space's diagonal."""


class OmplMethod:
    """OMPL as a `ReachMethod` for one scene. It plans in the first cycle.

    OMPL shortens and smooths each path. A moving average over the shortest window whose
    accelerations and jerks are within the limits of the arm turns it into a motion.
    """

    def __init__(self, scene: ReachingScene, goal: Goal, dt: float) -> None:
        self._scene, self._dt = scene, dt
        near = CollisionOptions(cut_off=MARGIN + 2.0 * EXTRA)
        self._world = reaching_world(scene.obstacles, scene.arm, near)
        self._tasks = reaching_tasks(scene, goal)
        self._commands = np.zeros((0, len(scene.start)))
        self._cycle = -1
        self.paths: tuple[JointPath, ...] = ()
        """Results of the searches."""
        self.reason = ""
        """Why no path was found; empty otherwise."""

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Return the joint speeds (n,), rad/s, of a cycle and a status; see `ReachMethod`."""
        if self._cycle < 0:
            self._plan(q)
        if self.reason:
            return np.zeros(len(q)), "stuck"
        return self.stop(q), ""

    def stop(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the joint speeds (n,) of the next cycle: the motion ends at rest."""
        self._cycle += 1
        ended = self._cycle > len(self._commands)
        return np.zeros(len(q)) if ended else self._commands[self._cycle - 1]

    def _plan(self, q: NDArray[np.float64]) -> None:
        self._cycle = 0
        for search in range(SEARCHES):
            began = time.perf_counter()
            goals = self._goals(q, np.random.default_rng([self._scene.seed, search]))
            self.reason = "no configuration reaches the goal"
            best: NDArray[np.float64] | None = None
            for _ in range(PATHS if len(goals) else 0):
                path = _ompl_path(q, goals, self._world.robot, self._checker(q, goals))
                self.reason = "OMPL found no path"
                if path is None:
                    break
                motion = _timed(path, self._world.robot, self._dt)
                best = motion if best is None or len(motion) < len(best) else best
            seconds = time.perf_counter() - began
            found = best is not None
            corners = q[None] if best is None else best
            reason = "" if found else self.reason
            path = JointPath(found, corners, self._dt, reason, 0, 0, seconds)
            self.paths = (*self.paths, path)
            if best is not None:
                self.reason = ""
                self._commands = np.diff(best, axis=0) / self._dt
                return

    def _goals(self, q: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
        """Return goal configurations (G, n) without contact, the nearest to the start first."""
        robot = self._world.robot
        seeds = [q, *rng.uniform(robot.lower, robot.upper, (SEEDS - 1, robot.n))]
        found = [one for one in map(self._solved, seeds) if one is not None]
        clear = [one for one in found if self._clearance(one) >= MARGIN]
        clear.sort(key=lambda one: float(np.linalg.norm(one - q)))
        return np.array(clear[:GOALS]).reshape(-1, robot.n)

    def _solved(self, q: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return a configuration (n,) that reaches the tasks: damped steps from a seed."""
        robot = self._world.robot
        for _ in range(IK_STEPS):
            state = robot.at(q)
            rows = [task.at(state) for task in self._tasks]
            error = np.concatenate([row.error for row in rows])
            if np.linalg.norm(error) < IK_ERROR:
                return q
            jacobian = np.concatenate([row.jacobian for row in rows])
            square = jacobian @ jacobian.T + DAMPING * np.eye(len(error))
            step = jacobian.T @ np.linalg.solve(square, error)
            step *= min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-12))
            q = np.clip(q + step, robot.lower, robot.upper)
        return None

    def _clearance(self, q: NDArray[np.float64]) -> float:
        return float(self._world.proximity(q).distance.min(initial=np.inf))

    def _checker(
        self, q: NDArray[np.float64], goals: NDArray[np.float64]
    ) -> Callable[[NDArray[np.float64]], bool]:
        ends = np.vstack([q, goals])
        start = min(MARGIN, 0.95 * self._clearance(q))

        def is_free(at: NDArray[np.float64]) -> bool:
            apart = np.abs(ends - at).max(axis=1)
            wanted = MARGIN + EXTRA
            if apart.min() < NEAR_ENDS:
                wanted = start if apart[0] < NEAR_ENDS else MARGIN
            return self._clearance(at) >= wanted

        return is_free


def _ompl_path(
    q: NDArray[np.float64],
    goals: NDArray[np.float64],
    robot: RobotModel,
    is_free: Callable[[NDArray[np.float64]], bool],
) -> NDArray[np.float64] | None:
    """Return a path (N, n) from q to one of the goals (G, n), or None."""
    from ompl import (  # pyright: ignore[reportMissingImports] - an extra
        base,
        geometric,
        util,
    )

    util.setLogLevel(util.LogLevel.LOG_NONE)
    n = len(q)
    space = base.RealVectorStateSpace(n)
    bounds = base.RealVectorBounds(n)
    for joint in range(n):
        bounds.setLow(joint, float(robot.lower[joint]))
        bounds.setHigh(joint, float(robot.upper[joint]))
    space.setBounds(bounds)

    # The stubs of OMPL do not know that states have indices.
    def state(values: NDArray[np.float64]) -> Any:
        one = cast("Any", space.allocState())
        for joint in range(n):
            one[joint] = float(values[joint])
        return one

    def joints(at: Any) -> NDArray[np.float64]:
        return np.array([at[joint] for joint in range(n)])

    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda at: is_free(joints(at)))
    information = setup.getSpaceInformation()
    information.setStateValidityCheckingResolution(RESOLUTION)
    setup.setStartState(state(q))
    ends = base.GoalStates(information)
    for goal in goals:
        ends.addState(state(goal))
    setup.setGoal(ends)
    setup.setPlanner(geometric.RRTConnect(information))
    setup.solve(SEARCH_S)
    if not setup.haveExactSolutionPath():
        return None
    setup.simplifySolution(SEARCH_S)
    path = setup.getSolutionPath()
    path.interpolate()
    return np.array([joints(at) for at in path.getStates()])


def _timed(path: NDArray[np.float64], robot: RobotModel, dt: float) -> NDArray[np.float64]:
    """Return the motion (M, n) along a path, one configuration per cycle, within all limits."""
    track = resample_path(path, robot, dt)
    still = np.zeros((1, robot.n))
    window = 0
    while True:
        window += 1
        padded = np.vstack([*[track[:1]] * window, track, *[track[-1:]] * window])
        total = np.cumsum(np.vstack([np.zeros_like(padded[:1]), padded]), axis=0)
        motion = (total[window:] - total[:-window]) / window
        speeds = np.vstack([still, np.diff(motion, axis=0) / dt, still])
        rates = np.diff(speeds, axis=0, prepend=still, append=still) / dt
        jerks = np.diff(rates, axis=0) / dt
        if np.all(np.abs(rates) <= robot.acceleration) and np.all(np.abs(jerks) <= robot.jerk):
            return motion

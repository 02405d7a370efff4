"""Reach with a search for a way: the controller first, and the planner where it is stuck."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from eyehand.control.approach import ApproachController
from eyehand.control.planner import plan
from eyehand.control.safety import safe_motion
from eyehand.control.task import DEFAULT_LINEAR_SPEED

from .controlled_reach import said

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control.collision_world import CollisionWorld
    from eyehand.control.options import ControlOptions
    from eyehand.control.planner import Way
    from eyehand.control.planner_options import PlannerOptions
    from eyehand.control.robot_model import RobotModel
    from eyehand.control.task import Aim

PATIENCE_S = 0.9
"""Without progress for so long the planner is asked: before the judge takes the arm, which may
stand still by then, for one that has given up."""
MOST_SEARCHES = 3
"""A way may be left where the safety level bends it; then another is looked for, no more often."""
NEAR_RAD = 0.02
"""The arm is where the way wants it when no joint is farther off."""
SPEED_SHARE = 0.5
"""Share of the joint speed limits that a way is gone with."""
ROUNDING = 1e-9
"""A way so many cycles longer than a whole number of them is not."""
HELD_UP_S = 0.5
"""The way is given up when the arm has not come where it wants it for so long."""


class PlannedReach:
    """The approach controller and, where it is stuck, a way that was found and is then followed.

    The safety level stands above the way too: what the search overlooked, at its longer steps,
    stops the arm.

    Parameters
    ----------
    world
        Arm and obstacles.
    aim
        What to reach.
    options
        Of the controller.
    planner
        Of the search.
    """

    def __init__(
        self,
        world: CollisionWorld,
        aim: Aim,
        options: ControlOptions,
        planner: PlannerOptions,
    ) -> None:
        self._world, self._aim, self._options, self._planner = world, aim, options, planner
        # The search takes the place of retreats.
        hasty = replace(options, patience=min(options.patience, PATIENCE_S), retreats=0)
        self._controller = ApproachController(world, (aim,), hasty)
        self._track: NDArray[np.float64] = np.empty((0, world.robot.n))
        self._at = 0
        self._held_up = 0.0
        self.ways: list[Way] = []
        """What the searches gave."""
        self.reason = ""
        """Why the last cycle's motion did not go on, or what held it back; empty when neither."""

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Give the joint speeds (7,), rad/s, of a cycle; see `ReachMethod`."""
        if self._at < len(self._track):
            return self._follow(q), ""
        cycle = self._controller.step(q)
        self.reason = said(cycle)
        if cycle.status != "stuck":
            return cycle.velocity, ""
        if len(self.ways) == MOST_SEARCHES:
            return cycle.velocity, "stuck"
        planner = replace(self._planner, seed=self._planner.seed + len(self.ways))
        way = plan(self._world, (self._aim,), q, self._options, planner)
        self.ways.append(way)
        if not way:
            self.reason = way.reason
            return cycle.velocity, "stuck"
        self._track, self._at = retimed(way.postures, self._world.robot, self._options.dt), 1
        self._controller.restart()
        return np.zeros_like(q), ""

    def _follow(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        state = self._world.robot.at(q)
        wish = (self._track[self._at] - state.q) / self._options.dt
        wish *= min(1.0, 1.0 / max(float(np.max(np.abs(wish) / state.speed)), 1.0))
        proximity = self._world.proximity(state.q)
        motion = safe_motion(wish, state.jacobian[:3], state, proximity, self._options)
        after = state.q + self._options.dt * motion.velocity
        if np.max(np.abs(self._track[self._at] - after)) <= NEAR_RAD:
            self._at, self._held_up = self._at + 1, 0.0
        else:
            self._held_up += self._options.dt
        if self._held_up > HELD_UP_S:
            self._track, self._at, self._held_up = self._track[:0], 0, 0.0
        return motion.velocity


def retimed(postures: NDArray[np.float64], robot: RobotModel, cycle: float) -> NDArray[np.float64]:
    """Go a way anew, as fast as it may be gone: one posture a cycle, first and last included.

    Every roll-out of a search slows down towards its end, and a way has several.

    Parameters
    ----------
    postures
        Joint angles along the way (N, n), rad.
    robot
        The arm.
    cycle
        Length of a cycle, s.

    Returns
    -------
    ndarray
        (M, n), linear between the given ones: no step moves the frame faster than an aim by
        default does, or a joint faster than a share of its limit.
    """
    tool = np.array([robot.at(q).position for q in postures])
    by_tool = np.linalg.norm(np.diff(tool, axis=0), axis=1) / DEFAULT_LINEAR_SPEED
    by_joint = np.max(np.abs(np.diff(postures, axis=0)) / (SPEED_SHARE * robot.speed), axis=1)
    times = np.concatenate([[0.0], np.cumsum(np.maximum(by_tool, by_joint))])
    count = int(np.ceil(times[-1] / cycle - ROUNDING)) + 1
    wanted = np.minimum(cycle * np.arange(count), times[-1])
    return np.column_stack([np.interp(wanted, times, column) for column in postures.T])

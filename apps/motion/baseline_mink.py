"""The baseline of reaching: mink, a library for differential inverse kinematics on MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.data_synth.scenes import ReachingScene, arm_spec, clearance_pairs, frame_views

from .arm_choice import reaching_robot
from .reach_outcome import Goal, ReachOptions, ReachOutcome, run_reach

# The settings below have the best success on seeds 0 to 119. Most of them hardly matter.
SOLVER = "daqp"
"""Solver of mink's quadratic program."""
RATE = 4.0
"""Share of the tool's distance to the goal that is covered per second, below MAX_SPEED, 1/s."""
POSTURE_COST = 1e-4
"""Weight of the starting posture, relative to the tool's position."""
DAMPING = 1e-4
"""Weight of small joint steps. More is smoother, and slower near singular postures."""
ORIENTATION_COST = {"position": 0.0, "axis": (0.3, 0.3, 0.0), "pose": 0.3}
"""Weight of the orientation of the tool by goal, m/rad; the rotation about its axis is free for an
axis."""
TURN_SPEED = 1.0
"""Limit of the tool's commanded angular speed, rad/s."""
MARGIN = 0.010
"""Distance that every pair of shapes must keep, m."""
APPROACH = 0.1
"""Share of its distance beyond the margin that a pair may lose in one cycle. mink's own `gain`
divides by the cycle time once too often; this is corrected below."""


@dataclass(frozen=True)
class MinkOptions:
    """Settings of mink."""

    speed: float = 0.25
    """Limit of the tool's commanded speed, m/s."""
    detection: float = 0.100
    """Distance below which a pair of shapes becomes a limit, m."""
    relaxation: float = 0.0
    """mink's `bound_relaxation`, m/s. A negative one makes a pair inside the margin leave it."""
    retreats: int = 0
    """Number of retreats of a stuck motion, to home and to its mirror image in turns."""


TUNED = MinkOptions(relaxation=-2e-4, retreats=2)
"""mink with the retreats of this package's controller, and the relaxation with the best success on
development scenes."""
PATIENCE_S = 0.9
"""Time without progress after which a motion is stuck, s: that of this package's controller."""
MIN_PROGRESS_M = 0.01
"""Minimum decrease of the distance from the goal that counts as progress, m."""
RETREAT_RATE = 0.6
"""Share of its joint distance that a retreat covers per second, 1/s."""
MAX_RETREAT_S = 10.0
"""Time limit of a retreat, s."""
AT_RETREAT_RAD = 0.1
"""Joint distance from the configuration at which a retreat ends, rad."""


def run_mink(
    scene: ReachingScene,
    options: MinkOptions | None = None,
    reach: ReachOptions | None = None,
) -> ReachOutcome:
    """Run a reaching scene with mink: a position task, a weak posture task, and all its limits.

    Joint ranges, joint speeds, and all pairs of shapes that can touch are limits of its quadratic
    program.

    Parameters
    ----------
    scene
        Start, goal and obstacles.
    options
        Settings of mink.
    reach
        Cycle time and time limit.

    Returns
    -------
    ReachOutcome
        The result. Its status is `infeasible` if the program had no solution.

    Raises
    ------
    ModuleNotFoundError
        If mink is not installed.
    """
    reach = reach or ReachOptions()
    method = MinkMethod(scene, options or MinkOptions(), reach.dt, reach.goal)
    return run_reach(scene, method, reach)


class MinkMethod:
    """mink as a `ReachMethod` for one scene."""

    def __init__(
        self, scene: ReachingScene, options: MinkOptions, dt: float, goal: Goal = "position"
    ) -> None:
        import mink

        self._options, self._dt, self._goal = options, dt, scene.goal
        self._axes = None if goal == "position" else scene.goal_axes
        model = arm_spec(scene.obstacles, scene.arm).compile()
        robot = reaching_robot(scene.arm)
        self._configuration = mink.Configuration(model, q=scene.start)
        self._tool = frame_views(model, self._configuration.data, scene.arm.frame)
        sites = [model.site(site).name for site in range(model.nsite)]
        kind = "site" if scene.arm.frame in sites else "body"
        self._reach = mink.FrameTask(
            scene.arm.frame,
            kind,
            position_cost=1.0,
            orientation_cost=ORIENTATION_COST[goal],
            gain=RATE * dt,
        )
        posture = mink.PostureTask(model, cost=POSTURE_COST, gain=RATE * dt)
        posture.set_target(scene.start)
        self._tasks = [self._reach, posture]
        self._retreat = mink.PostureTask(model, cost=1.0, gain=RETREAT_RATE * dt)
        self._best, self._stalled, self._retreats = np.inf, 0.0, 0
        self._retreat_left = 0.0
        self._refuges = (robot.home, robot.lower + robot.upper - robot.home)
        speeds = dict(zip(robot.joint_names, robot.speed, strict=True))
        pairs = [([int(a)], [int(b)]) for a, b in clearance_pairs(model)]
        self._limits = [
            mink.ConfigurationLimit(model),
            mink.VelocityLimit(model, speeds),
            mink.CollisionAvoidanceLimit(
                model,
                pairs,
                gain=APPROACH * dt,
                bound_relaxation=options.relaxation,
                minimum_distance_from_collisions=MARGIN,
                collision_detection_distance=options.detection,
            ),
        ]

    def __call__(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
        """Return the joint speeds (n,), rad/s, of a cycle and a status; see `ReachMethod`."""
        import mink

        configuration = self._configuration
        configuration.update(q)
        tool, matrix = self._tool
        offset = self._goal - tool
        # A target on the straight line to the goal limits the speed. For a position it has the
        # orientation of the tool, so that the error has no rotation.
        max_step = self._options.speed / RATE
        ahead = offset * min(1.0, max_step / max(float(np.linalg.norm(offset)), max_step))
        rotation = mink.SO3.from_matrix(matrix.reshape(3, 3))
        if self._axes is not None:
            axes = Rotation.from_matrix(rotation.as_matrix())
            turn = Rotation.from_matrix(self._axes) * axes.inv()
            most = TURN_SPEED / RATE
            turn = turn ** min(1.0, most / max(float(turn.magnitude()), most))
            rotation = mink.SO3.from_matrix((turn * axes).as_matrix())
        self._reach.set_target(mink.SE3.from_rotation_and_translation(rotation, tool + ahead))
        error = float(np.linalg.norm(offset))
        if self._axes is not None:
            error += float(np.linalg.norm(self._reach.compute_error(configuration)[3:]))
        tasks = [self._retreat] if self._retreating(q, error) else self._tasks
        try:
            speed = mink.solve_ik(
                configuration,
                tasks,
                self._dt,
                SOLVER,
                damping=DAMPING,
                limits=self._limits,
            )
        except mink.NoSolutionFound:
            return np.zeros_like(q), "infeasible"
        return speed, ""

    def _retreating(self, q: NDArray[np.float64], error: float) -> bool:
        """Return whether this cycle belongs to a retreat; start one if the motion is stuck."""
        if self._retreat_left > 0.0:
            self._retreat_left -= self._dt
            target = self._refuges[(self._retreats - 1) % 2]
            if np.linalg.norm(target - q) < AT_RETREAT_RAD:
                self._retreat_left = 0.0
            self._best, self._stalled = np.inf, 0.0
            return True
        if error < self._best - min(MIN_PROGRESS_M, 0.1 * error):
            self._best, self._stalled = error, 0.0
        self._stalled += self._dt
        if self._stalled < PATIENCE_S or self._retreats >= self._options.retreats:
            return False
        self._retreat.set_target(self._refuges[self._retreats % 2])
        self._retreats += 1
        self._retreat_left = MAX_RETREAT_S
        return True

"""Stress sweeps over goals at joint limits, with three methods to respect the limits."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import CollisionWorld, ControlOptions, RobotState, nominal_motion, safe_motion
from eyehand.control.tasks import AxisAlignment, Pose, Position, Task

from ..bench import Sweep, Trial
from .stress_trial import lbr_world

LimitMethod = Literal["clamp", "cost", "safety"]
"""``clamp``: joint angles are clipped to their limits. ``cost``: also, the null space of the tasks
lowers the cost of eq. 5. ``safety``: also, the limits are bounds of the quadratic program."""
POSITION, POSITION_AND_AXIS, POSE = 3.0, 5.0, 6.0
"""Rows of the tasks. With fewer rows, more joints are free to leave their limits."""
GOALS = 20
"""Number of goals per trial."""
AT_LIMIT = 2
"""Number of joints, of seven, at a limit in the posture of a goal."""
MIN_REACHED = 0.8
"""Share of its goals that a trial must reach. The others need a path that no local
method finds."""
NEAR_LIMIT = np.radians(2.0)
"""Angle to the limit, rad. It is larger than the angle that the safety level keeps."""
HOME_RANGE = 0.8
"""Maximum angle of the other joints from home, rad. It keeps the path to the goal simple."""
TIME_LIMIT_S = 12.0
"""Simulated time for a goal, s."""
CYCLE_S = 0.01
"""Control period, s. It is long because distances do not matter here and there are 1200 goals."""
MIN_PROGRESS = 0.01
"""Decrease of the error that counts as progress, m or rad."""
REACHED = 1e-3
"""Norm of the error below which a goal is reached, m and rad."""


def limit_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """Return one sweep per method."""
    names = {"clamp": "clamped joints", "cost": "cost of eq. 5", "safety": "bounds of the program"}
    return tuple(
        Sweep(
            name=f"limits-{method}",
            axis=f"{names[method]}, goal at limits: rows of the task",
            unit="",
            values=(POSITION, POSITION_AND_AXIS, POSE),
            holds_to=POSITION if method == "safety" else None,
            attempt=partial(_reach_goals, method=method),
            right=f"4 of 5 goals reached ({GOALS} per trial), no joint beyond its limit",
            repeats=10,
        )
        for method in ("clamp", "cost", "safety")
    )


def _reach_goals(rows: float, seed: int, options: ControlOptions, *, method: LimitMethod) -> Trial:
    world = _world()
    options = replace(options, dt=CYCLE_S, safety=method == "safety")
    if method == "clamp":
        options = replace(options, centring=0.0)
    rng = np.random.default_rng([seed, 5])
    reached, outside = 0, 0.0
    for _ in range(GOALS):
        posture = _posture_at_limits(rng, world, NEAR_LIMIT)
        state = world.robot.at(posture)
        success, beyond = _reach(world, _goals(state, round(rows)), options, method)
        reached += success
        outside = max(outside, beyond)
    share = reached / GOALS
    clean = outside <= 1e-9
    note = f"{reached} of {GOALS} reached" if clean else f"{outside:.1e} rad beyond a joint limit"
    return Trial(clean and share >= MIN_REACHED, note, clean=clean, score=share)


def _reach(
    world: CollisionWorld, goals: list[Task], options: ControlOptions, method: LimitMethod
) -> tuple[bool, float]:
    """Return whether a goal is reached from home, and the largest violation of a limit, rad."""
    robot = world.robot
    q, beyond, best, stalled = robot.home.copy(), 0.0, np.inf, 0
    for _ in range(round(TIME_LIMIT_S / options.dt)):
        state = robot.at(q)
        proximity = world.proximity(q)
        nominal = nominal_motion(state, goals, proximity, options)
        error = float(np.linalg.norm(np.concatenate([t.error for t in nominal.task_rows])))
        if error < REACHED:
            return True, beyond
        best, stalled = (error, 0) if error < best - MIN_PROGRESS else (best, stalled + 1)
        if stalled * options.dt > options.patience:
            break
        velocity = nominal.velocity
        if method == "safety":
            rows = np.concatenate([task.jacobian for task in nominal.task_rows])
            velocity = safe_motion(velocity, rows, state, proximity, options).velocity
            q = q + options.dt * velocity
        else:
            velocity = np.clip(velocity, -robot.speed, robot.speed)
            q = np.clip(q + options.dt * velocity, robot.lower, robot.upper)
        beyond = max(beyond, float(np.max(np.maximum(robot.lower - q, q - robot.upper))))
    return False, beyond


def _posture_at_limits(
    rng: np.random.Generator, world: CollisionWorld, near: float
) -> NDArray[np.float64]:
    """Return a posture with some joints near a limit and without self-collision."""
    robot = world.robot
    while True:
        q = robot.home + rng.uniform(-HOME_RANGE, HOME_RANGE, robot.n)
        q = np.clip(q, robot.lower + near, robot.upper - near)
        for joint in rng.choice(robot.n, AT_LIMIT, replace=False):
            upper = rng.random() < 0.5
            q[joint] = robot.upper[joint] - near if upper else robot.lower[joint] + near
        if world.proximity(q).distance.min(initial=1.0) > 0.03:
            return q


def _goals(state: RobotState, rows: int) -> list[Task]:
    """Return tasks for the position of the hand, its position and z-axis, or its pose."""
    if rows == POSITION:
        return [Position(state.position)]
    if rows == POSITION_AND_AXIS:
        return [
            Position(state.position),
            AxisAlignment(axis=np.array([0.0, 0.0, 1.0]), goal=state.rotation[:, 2]),
        ]
    rotation = Rotation.from_matrix(state.rotation)
    return [Pose(RigidTransform.from_components(state.position, rotation))]


@lru_cache(maxsize=1)
def _world() -> CollisionWorld:
    return lbr_world()

"""Goals that are met in postures at joint limits, by three ways of keeping to the limits."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import nominal_motion, safe_motion
from eyehand.control.tasks import AxisAlignment, Pose, Position

from ..bench import Sweep, Trial
from .stress_trial import lbr_world

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import CollisionWorld, ControlOptions, RobotState
    from eyehand.control.tasks import Task

Keeping = Literal["clamp", "cost", "safety"]
"""``clamp``: joints stop at their limits; ``cost``: the same, and what the tasks leave free lowers
the cost of eq. 5; ``safety``: that, and limits are bounds of the safety level's program."""
PLACE, PLACE_AND_AXIS, WHOLE = 3.0, 5.0, 6.0
"""Rows of the tasks: the fewer, the more joints are free to leave their limits."""
GOALS = 20
"""A trial."""
AT_LIMIT = 2
"""Joints of seven that the goal's posture has at a limit."""
RIGHT = 0.8
"""Share of its goals that a trial must reach: the others need a posture that no local way finds."""
NEAR_LIMIT = np.radians(2.0)
"""How near, rad: outside the angle that the safety level keeps from the limits."""
AROUND = 0.8
"""How far from home its other joints may be, rad: so that the way there is not the question."""
TIME_LIMIT_S = 12.0
"""Simulated time for a goal."""
CYCLE_S = 0.01
"""Control period here, s: distances do not matter, and 1200 goals are to be tried."""
MIN_PROGRESS = 0.01
"""Decrease of the error that counts as progress, m or rad."""
REACHED = 1e-3
"""Norm of the error, m and rad, that counts as reached."""


def limit_sweeps() -> tuple[Sweep[ControlOptions], ...]:
    """One sweep for each way."""
    told = {"clamp": "clamped joints", "cost": "cost of eq. 5", "safety": "bounds of the program"}
    return tuple(
        Sweep(
            name=f"limits-{keeping}",
            axis=f"{told[keeping]}, goal at limits: rows of the task",
            unit="",
            values=(PLACE, PLACE_AND_AXIS, WHOLE),
            holds_to=PLACE if keeping == "safety" else None,
            attempt=partial(_reach_goals, keeping=keeping),
            right=f"4 of 5 goals reached ({GOALS} a trial), no joint past its limit",
            repeats=10,
        )
        for keeping in ("clamp", "cost", "safety")
    )


def _reach_goals(rows: float, seed: int, options: ControlOptions, *, keeping: Keeping) -> Trial:
    world = _world()
    options = replace(options, dt=CYCLE_S, safety=keeping == "safety")
    if keeping == "clamp":
        options = replace(options, centring=0.0)
    rng = np.random.default_rng([seed, 5])
    reached, outside = 0, 0.0
    for _ in range(GOALS):
        posture = _posture_at_limits(rng, world, NEAR_LIMIT)
        state = world.robot.at(posture)
        done, beyond = _reach(world, _goals(state, round(rows)), options, keeping)
        reached += done
        outside = max(outside, beyond)
    share = reached / GOALS
    clean = outside <= 1e-9
    note = f"{reached} of {GOALS} reached" if clean else f"{outside:.1e} rad past a joint limit"
    return Trial(clean and share >= RIGHT, note, clean=clean, score=share)


def _reach(
    world: CollisionWorld, goals: list[Task], options: ControlOptions, keeping: Keeping
) -> tuple[bool, float]:
    """Whether a goal is reached from home, and how far a joint was past its limit, rad."""
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
        if keeping == "safety":
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
    """A posture with some joints near a limit, in which the arm does not touch itself."""
    robot = world.robot
    while True:
        q = robot.home + rng.uniform(-AROUND, AROUND, robot.n)
        q = np.clip(q, robot.lower + near, robot.upper - near)
        for joint in rng.choice(robot.n, AT_LIMIT, replace=False):
            upper = rng.random() < 0.5
            q[joint] = robot.upper[joint] - near if upper else robot.lower[joint] + near
        if world.proximity(q).distance.min(initial=1.0) > 0.03:
            return q


def _goals(state: RobotState, rows: int) -> list[Task]:
    """What of the hand's frame is a goal: its place, its place and z-axis, or all of it."""
    if rows == PLACE:
        return [Position(state.position)]
    if rows == PLACE_AND_AXIS:
        return [
            Position(state.position),
            AxisAlignment(axis=np.array([0.0, 0.0, 1.0]), goal=state.rotation[:, 2]),
        ]
    rotation = Rotation.from_matrix(state.rotation)
    return [Pose(RigidTransform.from_components(state.position, rotation))]


@lru_cache(maxsize=1)
def _world() -> CollisionWorld:
    return lbr_world()

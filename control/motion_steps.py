"""One control cycle step by step: the nominal motion of a stack, and the safe motion.

The steps are those of the compiled cycle, one call each. They are used for tasks of any class, and
for the cycles in which the kernel has no result (:mod:`cycle_kernels`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .braking import brake_from, command_rows
from .collision_world import CollisionWorld
from .cycle_kernels import CENTRING_POWER, limit_frame_speed, towards
from .options import ControlOptions
from .proximity import Proximity
from .relaxation import relaxed_rate
from .repulsion import limited_gradient
from .robot_state import RobotState
from .safety import safe_motion
from .stack import solve_stack
from .tasks.joint_centring import centring_slope
from .tasks.task import Task, TaskRows


class CycleResult(NamedTuple):
    """The motion of one control cycle: tasks, avoidance and safety together."""

    command: NDArray[np.float64]
    """(2, n): velocity, rad/s (m/s for slide joints), and its acceleration."""
    errors: tuple[float, ...]
    """Unmet error of each task, see :class:`TaskRows`: first the tasks of the stack, then the
    watched tasks."""
    beta: tuple[float, ...]
    """Weight of avoidance in each task of the stack (eq. 8)."""
    clearance: float
    """Minimum distance of all pairs nearer than the cut-off, m; inf if there are none."""
    name_blocking: Callable[[], tuple[str, ...]]
    """Returns `blocking`. Names take longer than the rest of the result, and few cycles need
    them."""
    feasible: bool
    """False if the safety level cannot satisfy all bounds. True without the safety level."""

    @property
    def blocking(self) -> tuple[str, ...]:
        """Names of the active constraints of the safety level, strongest first."""
        return self.name_blocking()

    @property
    def velocity(self) -> NDArray[np.float64]:
        """(n,), rad/s (m/s for slide joints)."""
        return self.command[0]


@dataclass(frozen=True)
class NominalMotion:
    """The motion commanded by tasks and avoidance, before the safety level."""

    velocity: NDArray[np.float64]
    """(n,), rad/s (m/s for slide joints)."""
    task_rows: tuple[TaskRows, ...]
    """Value, error and Jacobian of each task in this posture."""
    beta: tuple[float, ...]
    """Weight of avoidance in each task (eq. 8)."""


def nominal_motion(
    state: RobotState, tasks: Sequence[Task], proximity: Proximity, options: ControlOptions
) -> NominalMotion:
    """Compute the joint velocities of tasks and repulsion: relaxed motion control (eq. 8).

    Each task has its own weight β, with which avoidance changes its rate. The free joint
    motion follows the negative gradients of repulsion and joint centring.
    """
    task_rows = tuple(task.at(state) for task in tasks)
    gradient = limited_gradient(proximity, options)
    relaxed = [relaxed_rate(rows, gradient, options) for rows in task_rows]
    slopes = [
        centring_slope(q, (low, high), CENTRING_POWER, np.nan)
        for q, low, high in zip(state.q, state.lower, state.upper, strict=True)
    ]
    solution = solve_stack(
        task_rows,
        [rate for rate, _ in relaxed],
        free_motion=-options.centring * np.array(slopes) - gradient,
        speed=state.speed,
    )
    return NominalMotion(solution.velocity, task_rows, tuple(beta for _, beta in relaxed))


def motion_in_steps(
    world: CollisionWorld,
    q: NDArray[np.float64],
    tasks: Sequence[Task],
    options: ControlOptions,
    watched: Sequence[Task] = (),
    motion: NDArray[np.float64] | None = None,
    frame_speed: float = np.inf,
) -> CycleResult:
    """Return the motion of a cycle at joint positions q (n,), for tasks of any class.

    ``motion`` (2, n) is the velocity of the last command, and its acceleration; None if the joints
    may change their velocity at once. ``frame_speed`` limits the nominal motion, m/s.

    Raises
    ------
    InputError
        If q does not have shape (n,), or a task is not finite.
    """
    state = world.robot.at(q)
    proximity = world.proximity(state.q)
    nominal = nominal_motion(state, tasks, proximity, options)
    velocity, blocking, feasible = nominal.velocity, (), True
    limit_frame_speed(velocity, state.jacobian, frame_speed)
    braking = None if motion is None else brake_from(world, state, motion, options)
    if options.safety:
        rows = np.concatenate([task.jacobian for task in nominal.task_rows])
        safe = safe_motion(
            velocity, rows, state, proximity, options, world.robot.joint_names, braking
        )
        velocity, blocking, feasible = safe.velocity, safe.blocking, safe.feasible
    else:
        bounds = command_rows(velocity, state, proximity, options, braking, recover=True)
        command = np.zeros(len(velocity)) if braking is None else braking.command
        velocity = np.empty_like(command)
        towards(command, nominal.velocity, bounds.low, bounds.high, velocity)
    errors = [rows.unmet for rows in nominal.task_rows]
    errors += [task.at(state).unmet for task in watched]
    clearance = float(proximity.distance.min(initial=float("inf")))
    before = np.zeros(len(velocity)) if motion is None else motion[0]
    command = np.array([velocity, (velocity - before) / options.dt])
    return CycleResult(
        command, tuple(errors), nominal.beta, clearance, partial(tuple, blocking), feasible
    )

"""Joint velocities of a stack of tasks. A task moves only in the null space of the tasks above."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .stack_kernels import Levels, solve_levels
from .tasks.task import TaskRows


@dataclass(frozen=True)
class StackSolution:
    """Joint velocities of a stack, and the result for each task."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    missing: tuple[float, ...]
    """Norm of the part of each task's commanded rate that is missing."""
    scale: tuple[float, ...]
    """Fraction of each task's motion that the joint speed limits allow, 0 to 1."""
    dropped: tuple[bool, ...]
    """Whether each task is one-sided and dropped, because the others move its value as allowed."""


def solve_stack(
    tasks: Sequence[TaskRows],
    rates: Sequence[NDArray[np.float64]] | None = None,
    *,
    free_motion: NDArray[np.float64] | None = None,
    speed: NDArray[np.float64] | None = None,
) -> StackSolution:
    """Compute joint velocities that drive every task at its rate, in order of priority.

    This is the strict form of eqs. (2) and (3). Task k is solved in the null space Z of *all*
    tasks above it, dq += Z (J_k Z)^+ (rate_k - J_k dq), so that no task disturbs one above. Near a
    singularity the inverse is damped (Maciejewski and Klein 1988), direction by direction. The null
    space uses the undamped directions; otherwise lower tasks would disturb upper ones.

    Parameters
    ----------
    tasks
        Highest priority first.
    rates
        Commanded velocities by task, (m,) each; the tasks' own rates when None.
    free_motion
        Desired joint velocities (n,) in the null space of all tasks, -∇H of eq. 8.
    speed
        Joint speed limits (n,), rad/s. A task that would exceed one is scaled down as a whole;
        the tasks above are not changed.

    Raises
    ------
    InputError
        If there is no task, the tasks disagree on the number of joints, another argument has the
        wrong shape, or a number is not finite.
    """
    joints = _joints(tasks)
    wanted = [task.rate for task in tasks] if rates is None else list(rates)
    _check(tasks, wanted, joints, free_motion, speed)
    count, max_rows = len(tasks), max(len(rate) for rate in wanted)
    levels = Levels(
        np.array([len(rate) for rate in wanted]),
        np.array([task.side for task in tasks]),
        np.zeros((count, max_rows)),
        np.zeros((count, max_rows, joints)),
    )
    for index, (task, rate) in enumerate(zip(tasks, wanted, strict=True)):
        levels.rates[index, : len(rate)], levels.rows[index, : len(rate)] = rate, task.jacobian
    velocity, scale, dropped = np.empty(joints), np.empty(count), np.empty(count, dtype=bool)
    free = np.zeros(joints) if free_motion is None else np.asarray(free_motion, dtype=np.float64)
    limits = np.full(joints, np.inf) if speed is None else np.asarray(speed, dtype=np.float64)
    solve_levels(levels, free, limits, velocity, scale, dropped)
    missing = tuple(
        0.0 if gone else float(np.linalg.norm(rate - task.jacobian @ velocity))
        for task, rate, gone in zip(tasks, wanted, dropped.tolist(), strict=True)
    )
    return StackSolution(velocity, missing, tuple(scale.tolist()), tuple(dropped.tolist()))


def _joints(tasks: Sequence[TaskRows]) -> int:
    if not tasks:
        raise InputError("the stack needs at least one task")
    sizes = [task.jacobian.shape[1] for task in tasks]
    if len(set(sizes)) > 1:
        raise InputError(f"all tasks must have the same number of joints, got {sizes}")
    return sizes[0]


def _check(
    tasks: Sequence[TaskRows],
    rates: list[NDArray[np.float64]],
    joints: int,
    free_motion: NDArray[np.float64] | None,
    speed: NDArray[np.float64] | None,
) -> None:
    shapes, needed = [np.shape(rate) for rate in rates], [task.error.shape for task in tasks]
    if shapes != needed:
        raise InputError(
            f"the rates need one row for each row of the tasks: {needed}, got {shapes}"
        )
    for task, rate in zip(tasks, rates, strict=True):
        # The dot product is finite only if all entries are. It is faster than np.isfinite.
        if not math.isfinite(np.vdot(rate, rate)):
            raise InputError(f"task {task.name}: the rate must be finite, got {rate.tolist()}")
    if free_motion is not None:
        if np.shape(free_motion) != (joints,):
            raise InputError(f"free_motion must be ({joints},), got {np.shape(free_motion)}")
        if not math.isfinite(np.vdot(free_motion, free_motion)):
            raise InputError(f"free_motion must be finite, got {free_motion.tolist()}")
    if speed is not None and (np.shape(speed) != (joints,) or not np.min(speed) >= 0.0):
        raise InputError(f"speed must be ({joints},) and >= 0, got {np.asarray(speed).tolist()}")

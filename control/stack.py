"""A stack of tasks as joint velocities: each task moves only in what those above leave free."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .options import ControlOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .task import TaskRows

LOST = 1e-7
"""Singular values below this are no direction at all: rounding makes their vectors arbitrary."""
ROUNDING = 1e-12
"""A step that passes a joint's speed by no more, rad/s, is within it: where a level above has used
up a joint, the rounding of the levels below must not stop them."""


@dataclass(frozen=True)
class StackSolution:
    """Joint velocities of a stack, and what became of each task."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    free: NDArray[np.float64]
    """(n, r) orthonormal directions that no task uses; with ``mode="paper"`` the product of the
    projectors, (n, n)."""
    missing: tuple[float, ...]
    """By task: norm of the commanded rate that is not met."""
    scale: tuple[float, ...]
    """By task: share of its motion that joint speeds allow, 0 to 1."""
    dropped: tuple[bool, ...]
    """By task: one-sided and left out, because the others move its value the allowed way."""


def solve_stack(
    tasks: Sequence[TaskRows],
    rates: Sequence[NDArray[np.float64]] | None = None,
    *,
    free_motion: NDArray[np.float64] | None = None,
    speed: NDArray[np.float64] | None = None,
    options: ControlOptions | None = None,
) -> StackSolution:
    """Joint velocities that drive every task at its rate, in order of priority.

    Strict form of eq. 2-3: task k is solved in the null space Z of *all* tasks above it,
    dq += Z (J_k Z)^+ (rate_k - J_k dq), so that none disturbs one above. Near a singularity the
    inverse is damped (Maciejewski and Klein 1988), direction by direction; the null space is built
    from the undamped directions, or the lower tasks would leak into the upper. ``mode="paper"`` is
    eq. 2-3 as printed, with the same inverse.

    Parameters
    ----------
    tasks
        Highest priority first.
    rates
        Commanded velocities by task, (m,) each; the tasks' own rates when None.
    free_motion
        Joint velocities (n,) wanted where no task says otherwise, -∇H of eq. 8.
    speed
        Joint speed limits (n,), rad/s. A level that would pass one is scaled down as a whole;
        those above keep what they have.

    Raises
    ------
    InputError
        If there is no task, the tasks disagree on the number of joints, another argument has the
        wrong shape, or a number is not finite.
    """
    options = options or ControlOptions()
    joints = _joints(tasks)
    wanted = [task.rate for task in tasks] if rates is None else list(rates)
    _check(tasks, wanted, joints, free_motion, speed)
    dropped = [task.side != 0 and len(task.error) == 1 for task in tasks]
    while True:
        solution = _solve(tasks, wanted, dropped, joints, free_motion, speed, options)
        broken = [
            bool(gone and task.side * (task.jacobian @ solution.velocity - rate)[0] < -LOST)
            for task, rate, gone in zip(tasks, wanted, dropped, strict=True)
        ]
        if not any(broken):
            return solution
        # One at a time, the highest first: with it held, the next may move the allowed way.
        dropped[broken.index(True)] = False


def damped_inverse(
    jacobian: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Inverse (n, m) of rows (m, n), damped near singularities; right vectors (n, n); rank."""
    u, s, vt = np.linalg.svd(jacobian, full_matrices=True)
    # A handful of numbers: plain Python is faster than arrays of them.
    sizes = [size for size in s.tolist() if size > LOST]
    rank = len(sizes)
    gains = [_damped_gain(size, options) for size in sizes]
    inverse = (vt[:rank].T * gains) @ u[:, :rank].T
    return inverse, vt.T, rank


def _damped_gain(size: float, options: ControlOptions) -> float:
    damping = options.damping**2 * max(1.0 - (size / options.near_singular) ** 2, 0.0)
    return size / (size**2 + damping)


def _solve(
    tasks: Sequence[TaskRows],
    rates: list[NDArray[np.float64]],
    dropped: list[bool],
    joints: int,
    free_motion: NDArray[np.float64] | None,
    speed: NDArray[np.float64] | None,
    options: ControlOptions,
) -> StackSolution:
    velocity = np.zeros(joints)
    # Strict: an orthonormal basis of what is free. Paper: the product of projectors, eq. 2.
    free = np.eye(joints)
    scales = []
    for task, rate, gone in zip(tasks, rates, dropped, strict=True):
        if gone or len(rate) == 0:
            scales.append(1.0)
            continue
        if options.mode == "paper":
            inverse, right, rank = damped_inverse(task.jacobian, options)
            step = free @ (inverse @ rate)
            free = free @ (right[:, rank:] @ right[:, rank:].T)
        elif free.shape[1] == 0:
            scales.append(0.0)
            continue
        else:
            inverse, right, rank = damped_inverse(task.jacobian @ free, options)
            step = free @ (inverse @ (rate - task.jacobian @ velocity))
            free = free @ right[:, rank:]
        scale = _allowed_share(velocity, step, speed)
        velocity = velocity + scale * step
        scales.append(scale)
    if free_motion is not None and free.shape[1] > 0:
        step = free @ free_motion if options.mode == "paper" else free @ (free.T @ free_motion)
        velocity = velocity + _allowed_share(velocity, step, speed) * step
    missing = tuple(
        0.0 if gone else _norm(rate - task.jacobian @ velocity)
        for task, rate, gone in zip(tasks, rates, dropped, strict=True)
    )
    return StackSolution(velocity, free, missing, tuple(scales), tuple(dropped))


def _allowed_share(
    velocity: NDArray[np.float64], step: NDArray[np.float64], speed: NDArray[np.float64] | None
) -> float:
    """Largest share of a step that keeps every joint within its speed."""
    if speed is None or (np.abs(velocity + step) <= speed + ROUNDING).all():
        return 1.0
    room = np.where(step > 0.0, speed - velocity, speed + velocity)
    size = np.abs(step)
    passing = size > np.maximum(room, 0.0) + ROUNDING
    if not passing.any():
        return 1.0
    return float(np.min(np.maximum(room[passing], 0.0) / size[passing]))


def _norm(vector: NDArray[np.float64]) -> float:
    """The norm of a few numbers, in less time than `np.linalg.norm` takes to start."""
    return math.sqrt(np.vdot(vector, vector))


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
        # One dot product is finite exactly when all entries are, and costs a third of asking.
        if not math.isfinite(np.vdot(rate, rate)):
            raise InputError(f"task {task.name}: the rate must be finite, got {rate.tolist()}")
    if free_motion is not None:
        if np.shape(free_motion) != (joints,):
            raise InputError(f"free_motion must be ({joints},), got {np.shape(free_motion)}")
        if not math.isfinite(np.vdot(free_motion, free_motion)):
            raise InputError(f"free_motion must be finite, got {free_motion.tolist()}")
    if speed is not None and (np.shape(speed) != (joints,) or not np.min(speed) >= 0.0):
        raise InputError(f"speed must be ({joints},) and >= 0, got {np.asarray(speed).tolist()}")

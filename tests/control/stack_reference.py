"""The stack in NumPy, strict and as the chapter prints it: the reference of the compiled one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.control.stack_kernels import DAMPING, LOST, NEAR_SINGULAR, ROUNDING
from eyehand.control.tasks import TaskRows


@dataclass(frozen=True)
class ReferenceSolution:
    """As `StackSolution`, with the free directions."""

    velocity: NDArray[np.float64]
    free: NDArray[np.float64]
    """(n, r) orthonormal directions that no task uses; in the printed form the product of the
    projectors, (n, n)."""
    missing: tuple[float, ...]
    scale: tuple[float, ...]
    dropped: tuple[bool, ...]


def solve_reference(
    tasks: Sequence[TaskRows],
    rates: Sequence[NDArray[np.float64]] | None = None,
    *,
    free_motion: NDArray[np.float64] | None = None,
    speed: NDArray[np.float64] | None = None,
    printed: bool = False,
    damping: float = DAMPING,
) -> ReferenceSolution:
    """Solve a stack; `printed` is eq. 2-3 as printed, where N1 N2 is not the common null space."""
    joints = tasks[0].jacobian.shape[1]
    wanted = [task.rate for task in tasks] if rates is None else list(rates)
    dropped = [task.side != 0 and len(task.error) == 1 for task in tasks]
    while True:
        solution = _solve(tasks, wanted, dropped, joints, free_motion, speed, printed, damping)
        broken = [
            bool(gone and task.side * (task.jacobian @ solution.velocity - rate)[0] < -LOST)
            for task, rate, gone in zip(tasks, wanted, dropped, strict=True)
        ]
        if not any(broken):
            return solution
        dropped[broken.index(True)] = False


def damped_inverse(
    jacobian: NDArray[np.float64], damping: float = DAMPING
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Inverse (n, m) of rows (m, n), damped near singularities; right vectors (n, n); rank."""
    u, s, vt = np.linalg.svd(jacobian, full_matrices=True)
    # A handful of numbers: plain Python is faster than arrays of them.
    sizes = [size for size in s.tolist() if size > LOST]
    rank = len(sizes)
    gains = [_damped_gain(size, damping) for size in sizes]
    inverse = (vt[:rank].T * gains) @ u[:, :rank].T
    return inverse, vt.T, rank


def _damped_gain(size: float, damping: float) -> float:
    weight = damping**2 * max(1.0 - (size / NEAR_SINGULAR) ** 2, 0.0)
    return size / (size**2 + weight)


def _solve(
    tasks: Sequence[TaskRows],
    rates: list[NDArray[np.float64]],
    dropped: list[bool],
    joints: int,
    free_motion: NDArray[np.float64] | None,
    speed: NDArray[np.float64] | None,
    printed: bool,
    damping: float,
) -> ReferenceSolution:
    velocity = np.zeros(joints)
    # Strict: an orthonormal basis of what is free. Paper: the product of projectors, eq. 2.
    free = np.eye(joints)
    scales = []
    for task, rate, gone in zip(tasks, rates, dropped, strict=True):
        if gone or len(rate) == 0:
            scales.append(1.0)
            continue
        if printed:
            inverse, right, rank = damped_inverse(task.jacobian, damping)
            step = free @ (inverse @ rate)
            free = free @ (right[:, rank:] @ right[:, rank:].T)
        elif free.shape[1] == 0:
            scales.append(0.0)
            continue
        else:
            inverse, right, rank = damped_inverse(task.jacobian @ free, damping)
            step = free @ (inverse @ (rate - task.jacobian @ velocity))
            free = free @ right[:, rank:]
        scale = _allowed_share(velocity, step, speed)
        velocity = velocity + scale * step
        scales.append(scale)
    if free_motion is not None and free.shape[1] > 0:
        step = free @ free_motion if printed else free @ (free.T @ free_motion)
        velocity = velocity + _allowed_share(velocity, step, speed) * step
    missing = tuple(
        0.0 if gone else _norm(rate - task.jacobian @ velocity)
        for task, rate, gone in zip(tasks, rates, dropped, strict=True)
    )
    return ReferenceSolution(velocity, free, missing, tuple(scales), tuple(dropped))


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

"""The task stack in NumPy, in strict and printed form: the reference for the compiled stack."""

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
    """The fields of `StackSolution` and the free directions."""

    velocity: NDArray[np.float64]
    free: NDArray[np.float64]
    """Orthonormal directions (n, r) that no task uses. In the printed form, the product (n, n) of
    the projectors."""
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
    """Solve a stack of tasks.

    With ``printed``, follow equations 2 and 3 as printed. Their product N1 N2 is not the projector
    onto the common null space.
    """
    joints = tasks[0].jacobian.shape[1]
    target_rates = [task.rate for task in tasks] if rates is None else list(rates)
    dropped = [task.side != 0 and len(task.error) == 1 for task in tasks]
    while True:
        solution = _solve(
            tasks, target_rates, dropped, joints, free_motion, speed, printed, damping
        )
        broken = [
            bool(inactive and task.side * (task.jacobian @ solution.velocity - rate)[0] < -LOST)
            for task, rate, inactive in zip(tasks, target_rates, dropped, strict=True)
        ]
        if not any(broken):
            return solution
        dropped[broken.index(True)] = False


def damped_inverse(
    jacobian: NDArray[np.float64], damping: float = DAMPING
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return the damped inverse (n, m) of rows (m, n), the right vectors (n, n) and the rank."""
    u, s, vt = np.linalg.svd(jacobian, full_matrices=True)
    # Plain Python is faster than NumPy for so few numbers.
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
    # Strict form: an orthonormal basis of the free directions. Printed form: the product of
    # projectors, eq. 2.
    free = np.eye(joints)
    scales = []
    for task, rate, inactive in zip(tasks, rates, dropped, strict=True):
        if inactive or len(rate) == 0:
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
        0.0 if inactive else _norm(rate - task.jacobian @ velocity)
        for task, rate, inactive in zip(tasks, rates, dropped, strict=True)
    )
    return ReferenceSolution(velocity, free, missing, tuple(scales), tuple(dropped))


def _allowed_share(
    velocity: NDArray[np.float64], step: NDArray[np.float64], speed: NDArray[np.float64] | None
) -> float:
    """Return the largest fraction of a step that keeps every joint within its speed limit."""
    if speed is None or (np.abs(velocity + step) <= speed + ROUNDING).all():
        return 1.0
    available = np.where(step > 0.0, speed - velocity, speed + velocity)
    size = np.abs(step)
    exceeding = size > np.maximum(available, 0.0) + ROUNDING
    if not exceeding.any():
        return 1.0
    return float(np.min(np.maximum(available[exceeding], 0.0) / size[exceeding]))


def _norm(vector: NDArray[np.float64]) -> float:
    """Return the norm of a short vector. This is faster than `np.linalg.norm`."""
    return math.sqrt(np.vdot(vector, vector))

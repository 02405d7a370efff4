"""Configurations that reach a stack of tasks, from several seeds, without regard to obstacles."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .kinematics_kernels import point_jacobian, set_posture
from .tasks.kernel_task import TASK_ROWS, Frame, Output
from .tasks.registry import MISFIT, evaluate_task

ITERATIONS = 60
"""Maximum number of Newton steps from one seed."""
DAMPING = 1e-4
"""Damping of a Newton step, relative to unit rows. It keeps steps finite at singularities."""
MAX_STEP = 0.4
"""Maximum change of a joint in one Newton step, rad or m."""
CONVERGED = 1e-5
"""Error of the tasks at which the iteration ends, m or rad."""


@dataclass(frozen=True, eq=False)
class Solutions:
    """The results of all seeds."""

    configurations: NDArray[np.float64]
    """(S, n), within the joint limits."""
    errors: NDArray[np.float64]
    """(S,): maximum unmet error of the tasks, m or rad."""


def solve_tasks(
    seeds: NDArray[np.float64],
    tasks: NDArray[np.float64],
    limits: NDArray[np.float64],
    frame: tuple[NDArray[np.float64], ...],
    views: tuple,
) -> Solutions:
    """Solve packed tasks from seeds (S, n) by damped Newton steps (Levenberg-Marquardt).

    Parameters
    ----------
    seeds
        (S, n), rad or m.
    tasks
        (K, columns), see `registry.pack_tasks`.
    limits
        (n, 5), see `RobotModel.limits`.
    frame
        Origin (3,), axes (9,) and moving joints (n,) of the controlled frame.
    views
        Model, data, ``qpos``, ``xanchor``, ``xaxis`` and the table of joints.
    """
    configurations = np.clip(seeds, limits[:, 0], limits[:, 1])
    errors = np.empty(len(seeds))
    for seed, q in enumerate(configurations):
        errors[seed] = solve_from(q, tasks, limits, *frame, *views)
    return Solutions(configurations, errors)


@njit(cache=True, nogil=True)
def solve_from(
    q, tasks, limits, origin, frame_axes, frame_moves, model, data, qpos, anchors, axes, joints
):
    """Improve q (n,) in place; return the maximum unmet error, m or rad."""
    n = len(q)
    most = len(tasks) * max(TASK_ROWS, n)
    rows, errors = np.zeros((most, n)), np.zeros(most)
    jacobian, work = np.zeros((6, n)), np.zeros((6, n))
    size = max(TASK_ROWS, n)
    value, rate, scratch = np.empty(size), np.empty(size), np.empty((size, n))
    best, best_q = np.inf, q.copy()
    for _ in range(ITERATIONS):
        set_posture(model, data, q, qpos, joints[:, 0])
        point_jacobian(origin, joints[:, 1], joints[:, 2], frame_moves, anchors, axes, jacobian)
        frame = Frame(q, limits, origin, frame_axes, jacobian, work)
        used, unmet = 0, 0.0
        for task in range(len(tasks)):
            error = np.empty(size)
            m, side, left = evaluate_task(tasks[task], frame, Output(value, error, scratch), rate)
            if m == MISFIT:
                return np.inf
            unmet = max(unmet, left)
            if side != 0 and left == 0.0:
                continue
            for row in range(m):
                rows[used], errors[used] = scratch[row], error[row]
                used += 1
        if not math.isfinite(unmet):
            return np.inf
        if unmet < best:
            best, best_q[:] = unmet, q
        if best < CONVERGED or used == 0:
            break
        step = _newton_step(rows[:used], errors[:used], q, limits)
        largest = np.abs(step).max()
        q += step * min(1.0, MAX_STEP / max(largest, 1e-12))
        for joint in range(n):
            q[joint] = min(max(q[joint], limits[joint, 0]), limits[joint, 1])
    q[:] = best_q
    return best


@njit(cache=True)
def _newton_step(rows, errors, q, limits):
    """Return the damped step (n,). A joint at a limit does not move beyond it."""
    n = len(q)
    free = np.ones(n)
    step = np.zeros(n)
    for _ in range(n):
        active = rows * free
        square = active @ active.T + DAMPING * np.eye(len(rows))
        step = active.T @ np.linalg.solve(square, errors)
        blocked = False
        for joint in range(n):
            beyond = q[joint] >= limits[joint, 1] and step[joint] > 0.0
            if beyond or (q[joint] <= limits[joint, 0] and step[joint] < 0.0):
                free[joint] = 0.0
                blocked = True
        if not blocked:
            break
    return step * free

"""Add obstacle avoidance to the rate of a task, with a weight β (eq. 8-10)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .options import ControlOptions
from .packed_options import BETA, pack_options
from .tasks.task import TaskRows

MAX_BETA = 1.0
"""Upper limit of a dynamic β. At this limit avoidance acts at full strength."""
EPSILON = 0.05
"""Minimum speed towards the goal with a dynamic β (eq. 10), m/s or rad/s."""


def relaxed_rate(
    task: TaskRows, gradient: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], float]:
    """Return the rate (m,) of a task with avoidance, and the weight β.

    The result is rate - β J ∇H (eq. 8-9). Motion against the gradient ∇H (n,) of the cost leads
    away from obstacles.
    """
    rate = np.array(task.rate)
    beta = relax(rate, np.ascontiguousarray(task.jacobian), gradient, pack_options(options))
    return rate, beta


@njit(cache=True)
def relax(rate, rows, gradient, options):
    """Add avoidance to a task's rate (m,) in place, and return the weight β (eq. 8-10)."""
    avoidance = np.empty(len(rate))
    push = size = 0.0
    for row in range(len(rate)):
        along = 0.0
        for joint in range(len(gradient)):
            along += rows[row, joint] * gradient[joint]
        avoidance[row] = along
        push += along * along
        size += rate[row] * rate[row]
    beta = options[BETA]
    if math.isnan(beta):
        beta = dynamic_beta(math.sqrt(size), math.sqrt(push))
    for row in range(len(rate)):
        rate[row] -= beta * avoidance[row]
    return beta


@njit(cache=True)
def dynamic_beta(rate, avoidance):
    """Return the largest β <= 1 with rate - ε >= β avoidance (eq. 10).

    `rate` and `avoidance` are norms. Near the goal the rate is below ε. There β is 0, so that
    avoidance does not prevent the task from reaching its goal.
    """
    room = max(rate - EPSILON, 0.0)
    if room == 0.0:
        return 0.0
    return room / avoidance if avoidance * MAX_BETA > room else MAX_BETA

"""Relaxed motion: how far avoidance may bend a task's straight line (eq. 8-10)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .packed_options import BETA, pack_options

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import ControlOptions
    from .tasks.task import TaskRows

MAX_BETA = 1.0
"""Upper limit of a dynamic β: avoidance at full strength, even far from the goal."""
EPSILON = 0.05
"""Speed towards the goal that a dynamic β always leaves (eq. 10), m/s or rad/s."""


def relaxed_rate(
    task: TaskRows, gradient: NDArray[np.float64], options: ControlOptions
) -> tuple[NDArray[np.float64], float]:
    """Return the rate (m,) of a task bent by avoidance, and the weight β.

    The rate is rate - β J ∇H (eq. 8-9): against the cost's gradient (n,), so it leads away from
    obstacles.
    """
    rate = np.array(task.rate)
    beta = relax(rate, np.ascontiguousarray(task.jacobian), gradient, pack_options(options))
    return rate, beta


@njit(cache=True)
def relax(rate, rows, gradient, options):
    """Bend a task's rate (m,) by avoidance in place, and return the weight β (eq. 8-10)."""
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
    """Return the largest β up to 1 with rate - ε >= β avoidance, both norms (eq. 10).

    Near the goal, where the rate falls below ε, β is 0 and nothing holds the task off.
    """
    room = max(rate - EPSILON, 0.0)
    if room == 0.0:
        return 0.0
    return room / avoidance if avoidance * MAX_BETA > room else MAX_BETA

"""The compiled bounds of the safety level."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .packed_options import DAMPER, DT, MARGIN

SLACK = 1e-9
"""Maximum violation that counts as rounding, rad/s or m/s."""
RECOVERY_SPEED = 0.1
"""Speed at which a part inside the margin must leave it, m/s."""
TASK_WEIGHT = 20.0
"""Cost of a change of the task motion; a change of any joint motion costs 1. With 0 the tasks have
no priority over free motion."""


class SafetyRows(NamedTuple):
    """Linear bounds on joint velocities: low <= velocity <= high, rows @ velocity >= min_rates."""

    low: NDArray[np.float64]
    """(n,), rad/s."""
    high: NDArray[np.float64]
    """(n,), rad/s."""
    rows: NDArray[np.float64]
    """(P, n): derivatives of the distances by the joints."""
    min_rates: NDArray[np.float64]
    """(P,), m/s: minimum rate of each distance."""


@njit(cache=True)
def min_distance_rate(distance, drift, options, recover):
    """Return the minimum rate of a distance, m/s; drift is the rate due to moving obstacles."""
    damping = options[DAMPER] / options[DT]
    left = distance - options[MARGIN]
    rate = -damping * left
    recovery = RECOVERY_SPEED if recover else 0.0
    return (rate if left >= 0.0 else min(rate, recovery)) - drift


@njit(cache=True)
def satisfies(velocity, bounds):
    """Return whether a velocity (n,) satisfies all :class:`SafetyRows`."""
    low, high, rows, min_rates = bounds
    for joint in range(len(velocity)):
        if not low[joint] - SLACK <= velocity[joint] <= high[joint] + SLACK:
            return False
    for row in range(len(rows)):
        rate = 0.0
        for joint in range(len(velocity)):
            rate += rows[row, joint] * velocity[joint]
        if not rate >= min_rates[row] - SLACK:
            return False
    return True


@njit(cache=True)
def deviation_cost(sizes, rows):
    """Return the matrix (n, n) 1 + TASK_WEIGHT JᵀJ over the rows of all tasks."""
    joints = rows.shape[2]
    cost = np.eye(joints)
    for task in range(len(sizes)):
        for row in range(sizes[task]):
            for i in range(joints):
                weighted = TASK_WEIGHT * rows[task, row, i]
                for j in range(i + 1):
                    cost[i, j] += weighted * rows[task, row, j]
    for i in range(joints):
        for j in range(i):
            cost[j, i] = cost[i, j]
    return cost

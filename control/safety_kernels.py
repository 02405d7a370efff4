"""The bounds of the safety level, compiled: see `safety.safety_rows` and `SafetyRows.allow`."""

from __future__ import annotations

import numpy as np
from numba import njit

from .packed_options import DAMPER, DT, LIMIT_MARGIN, MARGIN, RECOVERY_SPEED, TASK_WEIGHT
from .safety import SLACK


@njit(cache=True)
def joint_bounds(q, limits, options, low, high):
    """Fill the least and greatest velocities (n,); ``limits`` (n, 3): lower, upper, speed."""
    share = options[DAMPER] / options[DT]
    for joint in range(len(q)):
        speed = limits[joint, 2]
        below = q[joint] - (limits[joint, 0] + options[LIMIT_MARGIN])
        above = (limits[joint, 1] - options[LIMIT_MARGIN]) - q[joint]
        low[joint] = min(max(-share * below, -speed), speed)
        high[joint] = max(min(share * above, speed), -speed)
        # A range narrower than the two margins leaves its middle.
        if low[joint] > high[joint]:
            low[joint] = high[joint] = 0.5 * (low[joint] + high[joint])


@njit(cache=True)
def least_change(distance, drift, options):
    """Slowest change of a distance that is allowed, m/s."""
    share = options[DAMPER] / options[DT]
    left = distance - options[MARGIN]
    fastest = -share * left
    return (fastest if left >= 0.0 else min(fastest, options[RECOVERY_SPEED])) - drift


@njit(cache=True)
def allowed(velocity, low, high, rows, least):
    """Tell whether a velocity (n,) keeps all bounds."""
    for joint in range(len(velocity)):
        if not low[joint] - SLACK <= velocity[joint] <= high[joint] + SLACK:
            return False
    for row in range(len(rows)):
        change = 0.0
        for joint in range(len(velocity)):
            change += rows[row, joint] * velocity[joint]
        if not change >= least[row] - SLACK:
            return False
    return True


@njit(cache=True)
def bending_cost(sizes, rows, options):
    """Matrix (n, n) of the cost of bending: 1 + task_weight JᵀJ over the rows of all tasks."""
    joints = rows.shape[2]
    cost = np.eye(joints)
    for task in range(len(sizes)):
        for row in range(sizes[task]):
            for i in range(joints):
                weighted = options[TASK_WEIGHT] * rows[task, row, i]
                for j in range(i + 1):
                    cost[i, j] += weighted * rows[task, row, j]
    for i in range(joints):
        for j in range(i):
            cost[j, i] = cost[i, j]
    return cost

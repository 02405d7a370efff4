"""Tasks of packed tasks in one posture, compiled: errors, rows, commanded rates, sides."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .packed_aims import (
    AXIS_ALIGNMENT,
    BOUNDED,
    DISTANCE_TO_AXIS,
    DISTANCE_TO_POINT,
    FIELDS,
    GAIN,
    HIGH,
    JOINT_CENTRING,
    KIND,
    LOOK_AT,
    LOW,
    ORIENTATION,
    POINT,
    POINT_ON_PLANE,
    POSE,
    POSITION,
    SPEED,
)
from .point_task_kernels import (
    distance_to_axis_task,
    distance_to_point_task,
    moved_point,
    point_on_plane_task,
    position_task,
)
from .turn_task_kernels import axis_alignment_task, look_at_task, orientation_task, pose_task

UNFIT = -1
"""Number of rows that says: an interval about a task of several rows, which its `at` refuses."""


@njit(cache=True)
def task_of(task, q, ranges, position, axes, jacobian, work, error, rate, rows):
    """Fill one task of a packed task (see :mod:`packed_aims`).

    Parameters
    ----------
    task
        Row of `pack_tasks`.
    q
        (n,).
    ranges
        (n, 2): lower and upper joint limits.
    position, axes, jacobian
        Of the controlled frame: (3,), (9,), (6, n), world.
    work
        (6, n) to work in.
    error, rate, rows
        To be filled: (M,), (M,), (M, n) with M at least 6 and n.

    Returns
    -------
    m, side, unmet
        Number of rows (or UNFIT), side and norm of the error that counts, as in :class:`TaskRows`.
    """
    kind, gain, speed, fields = task[KIND], task[GAIN], task[SPEED], task[FIELDS:]
    point, value = np.zeros(3), np.zeros(1)
    linear, motion = work[:3], work[3:]
    side = 0
    if kind <= POINT_ON_PLANE or kind in (POSE, LOOK_AT):
        moved_point(task[POINT:FIELDS], position, axes, jacobian, point, linear)
    if kind == POSITION:
        m = position_task(fields, point, linear, error, rows)
    elif kind == DISTANCE_TO_POINT:
        m = distance_to_point_task(fields, point, linear, value, error, rows)
    elif kind == DISTANCE_TO_AXIS:
        m = distance_to_axis_task(fields, point, linear, value, error, rows)
    elif kind == POINT_ON_PLANE:
        m = point_on_plane_task(fields, point, linear, value, error, rows)
    elif kind == ORIENTATION:
        m = orientation_task(fields, axes, jacobian, error, rows)
    elif kind == POSE:
        m, speed = pose_task(fields, gain, speed, point, linear, axes, jacobian, error, rows)
    elif kind == AXIS_ALIGNMENT:
        m = axis_alignment_task(fields, axes, jacobian, motion, error, rows)
    elif kind == LOOK_AT:
        m = look_at_task(fields, point, linear, axes, jacobian, motion, value, error, rows)
        if m == 1:
            m, side = _bounded(value[0], -np.inf, fields[12], gain, speed, error)
    else:
        m = len(q)
        value[0] = q[0]
        rows[:m] = 0.0
        for joint in range(m):
            rows[joint, joint] = 1.0
            if kind == JOINT_CENTRING:
                given = fields[1] != 0.0
                reference = fields[2 + joint] if given else np.nan
                error[joint] = -centring_slope(q[joint], ranges[joint], fields[0], reference)
            else:
                error[joint] = fields[joint] - q[joint]
    if task[BOUNDED] != 0.0 and m > 0:
        if m > 1:
            return UNFIT, 0, 0.0
        m, side = _bounded(value[0], task[LOW], task[HIGH], gain, speed, error)
    size = _command(error[:m], gain, speed, rate)
    return m, side, max(0.0, side * error[0]) if side else size


@njit(cache=True)
def centring_slope(q, span, power, reference):
    """Slope of a joint's cost of eq. (5) from its limits (2,); about their middle for a NaN."""
    width = span[1] - span[0]
    if not 0.0 < width < np.inf:
        return 0.0
    away = q - (0.5 * (span[0] + span[1]) if math.isnan(reference) else reference)
    return power * (away ** int(power - 1) / width)


@njit(cache=True)
def _command(error, gain, speed, rate):
    """Fill the commanded rate, gain times error cut to a speed; norm of the error."""
    square = 0.0
    for row in range(len(error)):
        rate[row] = gain * error[row]
        square += error[row] * error[row]
    size = math.sqrt(square)
    if gain * size > speed:
        for row in range(len(error)):
            rate[row] *= speed / (gain * size)
    return size


@njit(cache=True)
def _bounded(value, low, high, gain, speed, error):
    """Number of rows and side of keeping a value between bounds; see `interval.bounded`."""
    upper = high - value < value - low
    error[0] = (high if upper else low) - value
    inside = error[0] if upper else -error[0]
    if low < high and inside * gain > speed:
        return 0, 0
    if low == high:
        return 1, 0
    return 1, -1 if upper else 1

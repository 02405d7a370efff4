"""The compiled tasks by number, and how the control cycle evaluates them.

To add a task, write one file with its kernel and its class (:mod:`position` is the pattern), and
register it here: its class at the end of `KERNEL_TASKS`, its kernel in `_rows` under its number.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .axis_alignment import AxisAlignment, axis_alignment_rows
from .distance import DistanceToAxis, DistanceToPoint, distance_to_axis_rows, distance_to_point_rows
from .interval import Interval, bound
from .joint_centring import JointCentring, joint_centring_rows
from .kernel_task import BOUNDED, GAIN, HIGH, KIND, LOW, KernelTask, pack
from .look_at import LookAt, look_at_rows
from .orientation import Orientation, orientation_rows
from .plane import PointOnPlane, point_on_plane_rows
from .pose import Pose, pose_rows
from .position import Position, position_rows
from .posture import Posture, posture_rows
from .task import Task

KERNEL_TASKS: tuple[type[KernelTask], ...] = (
    Position,
    DistanceToPoint,
    DistanceToAxis,
    PointOnPlane,
    Orientation,
    Pose,
    AxisAlignment,
    LookAt,
    JointCentring,
    Posture,
)
"""Classes of the compiled tasks. The index is the kind, by which `_rows` selects the kernel."""
MISFIT = -1
"""Number of rows that marks an interval about a task of several rows. `Interval.at` rejects it."""


@njit(cache=True)
def _rows(task, frame, out):
    """Call the kernel of a packed task."""
    # Numba cannot cache a function that indexes a tuple of functions.
    kind = task[KIND]
    if kind == 0:
        return position_rows(task, frame, out)
    if kind == 1:
        return distance_to_point_rows(task, frame, out)
    if kind == 2:
        return distance_to_axis_rows(task, frame, out)
    if kind == 3:
        return point_on_plane_rows(task, frame, out)
    if kind == 4:
        return orientation_rows(task, frame, out)
    if kind == 5:
        return pose_rows(task, frame, out)
    if kind == 6:
        return axis_alignment_rows(task, frame, out)
    if kind == 7:
        return look_at_rows(task, frame, out)
    if kind == 8:
        return joint_centring_rows(task, frame, out)
    return posture_rows(task, frame, out)


def pack_tasks(tasks: Sequence[Task], joints: int) -> NDArray[np.float64] | None:
    """Return tasks as rows (K, columns) for the control cycle.

    Return None if one task is not of a registered class. A subclass is not, because it may change
    what the task does.

    Raises
    ------
    InputError
        If a task does not fit a robot with this number of joints.
    """
    packed = []
    for task in tasks:
        inner = task.task if type(task) is Interval else task
        if not isinstance(inner, KernelTask) or type(inner) not in KERNEL_TASKS:
            return None
        row = pack(inner, joints)
        row[KIND] = KERNEL_TASKS.index(type(inner))
        if type(task) is Interval:
            row[[BOUNDED, LOW, HIGH]] = 1.0, task.low, task.high
        packed.append(row)
    rows = np.zeros((len(packed), max(map(len, packed), default=0)))
    for row, one in zip(rows, packed, strict=True):
        row[: len(one)] = one
    return rows


@njit(cache=True)
def evaluate_task(task, frame, out, rate):
    """Fill value, error, rows and commanded rate (M,) of a packed task.

    Returns
    -------
    m, side, unmet
        Number of rows (or MISFIT); side and unmet error as in :class:`TaskRows`.
    """
    m, side, speed = _rows(task, frame, out)
    if task[BOUNDED] != 0.0 and m > 0:
        if m > 1:
            return MISFIT, 0, 0.0
        m, side, out.error[0] = bound(out.value[0], task[LOW], task[HIGH], task[GAIN], speed)
    size = _limited_rate(out.error[:m], task[GAIN], speed, rate)
    return m, side, max(0.0, side * out.error[0]) if side else size


@njit(cache=True)
def _limited_rate(error, gain, speed, rate):
    """Fill gain times error with its norm limited to ``speed``; return the norm of the error."""
    square = 0.0
    for row in range(len(error)):
        rate[row] = gain * error[row]
        square += error[row] * error[row]
    size = math.sqrt(square)
    if gain * size > speed:
        for row in range(len(error)):
            rate[row] *= speed / (gain * size)
    return size

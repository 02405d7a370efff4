"""Built-in tasks as rows of numbers, for compiled kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .interval import Interval
from .point_aims import DistanceToAxis, DistanceToPoint, PointOnPlane, Position
from .posture_aims import JointCentring, Posture
from .turn_aims import AxisAlignment, LookAt, Orientation, Pose

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .task import Task

KIND, GAIN, SPEED, BOUNDED, LOW, HIGH, POINT, FIELDS = 0, 1, 2, 3, 4, 5, 6, 9
"""Columns of a row: kind of task, 1 if it is inside an :class:`Interval` with the two bounds that
follow, point of the hand (3,), and from FIELDS on what the kind needs."""

(
    POSITION,
    DISTANCE_TO_POINT,
    DISTANCE_TO_AXIS,
    POINT_ON_PLANE,
    ORIENTATION,
    POSE,
    AXIS_ALIGNMENT,
    LOOK_AT,
    JOINT_CENTRING,
    POSTURE,
) = range(10)
"""Kinds of tasks."""

FIELDS_MOST = 13
"""Most fields of a kind that do not grow with the number of joints: those of a pose."""

_BUILT_IN = {
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
}
_NO_POINT = np.zeros(3)


def pack_tasks(tasks: Sequence[Task], joints: int) -> NDArray[np.float64] | None:
    """Rows (K, columns) of built-in tasks for a robot with so many joints.

    None where one is of another class (a subclass may do anything), or does not fit the robot: its
    own `at` then says what is wrong.
    """
    rows = np.zeros((len(tasks), FIELDS + max(FIELDS_MOST, 2 + joints)))
    for row, task in zip(rows, tasks, strict=True):
        if type(task) is Interval:
            row[BOUNDED], row[LOW], row[HIGH] = 1.0, task.low, task.high
            task = task.task
        if type(task) not in _BUILT_IN:
            return None
        kind, gain, speed, point, fields = _pack(task)
        sizes = {POSTURE: (joints,), JOINT_CENTRING: (2, 2 + joints)}.get(kind)
        if sizes is not None and len(fields) not in sizes:
            return None
        row[[KIND, GAIN, SPEED]] = kind, gain, speed
        row[POINT:FIELDS] = point
        row[FIELDS : FIELDS + len(fields)] = fields
    return rows


def _pack(task: Task) -> tuple[int, float, float, NDArray[np.float64], list[float]]:
    """Kind, gain, speed, point and fields of a task, the fields in the order kernels read them."""
    match task:
        case Position():
            packed = POSITION, task.point, [*task.goal]
        case DistanceToPoint():
            packed = DISTANCE_TO_POINT, task.point, [*task.centre, task.distance]
        case DistanceToAxis():
            fields = [*task.point_on_axis, *task._across.ravel(), task.distance]
            packed = DISTANCE_TO_AXIS, task.point, fields
        case PointOnPlane():
            packed = POINT_ON_PLANE, task.point, [*task.normal, task.offset]
        case Orientation():
            packed = ORIENTATION, _NO_POINT, [*task._goal.ravel()]
        case Pose():
            fields = [*task._rotation.ravel(), *task._position, task.turn_speed]
            packed = POSE, task.point, fields
        case AxisAlignment():
            packed = AXIS_ALIGNMENT, _NO_POINT, [*task._across.ravel(), *task.goal, *task.axis]
        case LookAt():
            fields = [*task._across.ravel(), *task.axis, *task.target, task.half_angle]
            packed = LOOK_AT, task.point, fields
        case JointCentring():
            reference = [] if task.reference is None else [*task.reference]
            packed = JOINT_CENTRING, _NO_POINT, [task.power, bool(reference), *reference]
        case Posture():
            packed = POSTURE, _NO_POINT, [*task.goal]
        case _:
            raise TypeError(f"no built-in task: {task!r}")
    kind, point, fields = packed
    return kind, task.gain, task.speed, point, [float(field) for field in fields]

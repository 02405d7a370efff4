"""Built-in aims as rows of numbers, for compiled kernels."""

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

    from .task import Aim

KIND, GAIN, SPEED, BOUNDED, LOW, HIGH, POINT, FIELDS = 0, 1, 2, 3, 4, 5, 6, 9
"""Columns of a row: kind of aim, 1 if it is inside an :class:`Interval` with the two bounds that
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
"""Kinds of aims."""

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


def pack_aims(aims: Sequence[Aim], joints: int) -> NDArray[np.float64] | None:
    """Rows (K, columns) of built-in aims for a robot with so many joints.

    None where one is of another class (a subclass may do anything), or does not fit the robot: its
    own `at` then says what is wrong.
    """
    rows = np.zeros((len(aims), FIELDS + max(FIELDS_MOST, 2 + joints)))
    for row, aim in zip(rows, aims, strict=True):
        if type(aim) is Interval:
            row[BOUNDED], row[LOW], row[HIGH] = 1.0, aim.low, aim.high
            aim = aim.aim
        if type(aim) not in _BUILT_IN:
            return None
        kind, gain, speed, point, fields = _pack(aim)
        sizes = {POSTURE: (joints,), JOINT_CENTRING: (2, 2 + joints)}.get(kind)
        if sizes is not None and len(fields) not in sizes:
            return None
        row[[KIND, GAIN, SPEED]] = kind, gain, speed
        row[POINT:FIELDS] = point
        row[FIELDS : FIELDS + len(fields)] = fields
    return rows


def _pack(aim: Aim) -> tuple[int, float, float, NDArray[np.float64], list[float]]:
    """Kind, gain, speed, point and fields of an aim, the fields in the order kernels read them."""
    match aim:
        case Position():
            packed = POSITION, aim.point, [*aim.goal]
        case DistanceToPoint():
            packed = DISTANCE_TO_POINT, aim.point, [*aim.centre, aim.distance]
        case DistanceToAxis():
            fields = [*aim.point_on_axis, *aim._across.ravel(), aim.distance]
            packed = DISTANCE_TO_AXIS, aim.point, fields
        case PointOnPlane():
            packed = POINT_ON_PLANE, aim.point, [*aim.normal, aim.offset]
        case Orientation():
            packed = ORIENTATION, _NO_POINT, [*aim._goal.ravel()]
        case Pose():
            fields = [*aim._rotation.ravel(), *aim._position, aim.turn_speed]
            packed = POSE, aim.point, fields
        case AxisAlignment():
            packed = AXIS_ALIGNMENT, _NO_POINT, [*aim._across.ravel(), *aim.goal, *aim.axis]
        case LookAt():
            fields = [*aim._across.ravel(), *aim.axis, *aim.target, aim.half_angle]
            packed = LOOK_AT, aim.point, fields
        case JointCentring():
            reference = [] if aim.reference is None else [*aim.reference]
            packed = JOINT_CENTRING, _NO_POINT, [aim.power, bool(reference), *reference]
        case Posture():
            packed = POSTURE, _NO_POINT, [*aim.goal]
        case _:
            raise TypeError(f"no built-in aim: {aim!r}")
    kind, point, fields = packed
    return kind, aim.gain, aim.speed, point, [float(field) for field in fields]

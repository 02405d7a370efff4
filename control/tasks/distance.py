"""The tasks on the distance of a point of the hand from a point or from an axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .inputs import check_gain_and_speed, number, origin, store, tangents, unit, vector
from .kernel_task import FIELDS, SPEED, KernelTask, moved_point
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED

MIN_DISTANCE = 1e-9
"""Minimum distance with a direction, m. The direction of a smaller one is rounding error."""


@njit(cache=True)
def distance_to_point_rows(task, frame, out):
    """Fill the row of `DistanceToPoint`; parameters: centre (3,), distance."""
    x, y, z = moved_point(task, frame)
    offset = (x - task[FIELDS], y - task[FIELDS + 1], z - task[FIELDS + 2])
    out.value[0] = _length_row(offset, frame.work[:3], out.rows[0])
    out.error[0] = task[FIELDS + 3] - out.value[0]
    return 1, 0, task[SPEED]


@njit(cache=True)
def distance_to_axis_rows(task, frame, out):
    """Fill the rows of `DistanceToAxis`; parameters: point (3,), tangents (2, 3), distance."""
    fields, linear = task[FIELDS:], frame.work[:3]
    x, y, z = moved_point(task, frame)
    x, y, z = x - fields[0], y - fields[1], z - fields[2]
    first = fields[3] * x + fields[4] * y + fields[5] * z
    second = fields[6] * x + fields[7] * y + fields[8] * z
    # The rows of the two coordinates, in scratch memory that is free here.
    coordinates = frame.work[3:5]
    for row in range(2):
        for column in range(linear.shape[1]):
            total = 0.0
            for axis in range(3):
                total += fields[3 + 3 * row + axis] * linear[axis, column]
            coordinates[row, column] = total
    distance = fields[9]
    if distance == 0.0:
        out.value[0], out.value[1] = first, second
        out.error[0], out.error[1] = -first, -second
        out.rows[0], out.rows[1] = coordinates[0], coordinates[1]
        return 2, 0, task[SPEED]
    out.value[0] = _length_row((first, second), coordinates, out.rows[0])
    out.error[0] = distance - out.value[0]
    return 1, 0, task[SPEED]


@njit(cache=True)
def _length_row(offset, coordinates, row):
    """Return the length of an offset (k,), and fill its derivative (n,).

    If the length is 0, the derivative is that of the coordinate that the joints move best.
    """
    square = 0.0
    for axis in range(len(offset)):
        square += offset[axis] * offset[axis]
    length = math.sqrt(square)
    if length < MIN_DISTANCE:
        best, largest = 0, -1.0
        for axis in range(len(offset)):
            size = 0.0
            for column in range(len(row)):
                size += coordinates[axis, column] * coordinates[axis, column]
            if size > largest:
                best, largest = axis, size
        row[:] = coordinates[best]
        return length
    for column in range(len(row)):
        total = 0.0
        for axis in range(len(offset)):
            total += offset[axis] * coordinates[axis, column]
        row[column] = total / length
    return length


@dataclass(frozen=True, eq=False)
class DistanceToPoint(KernelTask):
    """Bring a point of the hand to a distance from a centre, from any side: 1 row (eq. 4).

    The value is the distance, m. The chapter uses the Jacobian of half the squared distance. Here
    it is that of the distance, so that the commanded speed is a speed in m/s. At the centre the
    distance has no derivative. The row is then that of the world axis along which the joints move
    the point best. A goal of 0 has one row too, which keeps only the distance. To keep a point at a
    goal with three rows, use :class:`Position`.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    kernel: ClassVar = staticmethod(distance_to_point_rows)

    centre: NDArray[np.float64]
    """(3,), m, world."""
    distance: float
    """Goal, m, at least 0."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """Speed limit, m/s."""
    name: str = "distance to point"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(
            self,
            centre=vector(self.name, "centre", self.centre),
            distance=number(self.name, "distance", self.distance, low=0.0),
            point=vector(self.name, "point", self.point),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self.centre, self.distance]


@dataclass(frozen=True, eq=False)
class DistanceToAxis(KernelTask):
    """Bring a point of the hand to a distance from a line, anywhere along and around it.

    A goal above 0 has 1 row, and the value is the distance, m. On the line itself, the row is that
    of the perpendicular direction along which the joints move the point best. A goal of 0 has 2
    rows, and the values are the two coordinates perpendicular to the line, m. They are smooth on
    the line, and the distance is not.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    kernel: ClassVar = staticmethod(distance_to_axis_rows)

    point_on_axis: NDArray[np.float64]
    """A point on the line (3,), m, world."""
    direction: NDArray[np.float64]
    """Direction of the line (3,), world, of any length."""
    distance: float
    """Goal, m, at least 0."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """Speed limit, m/s."""
    name: str = "distance to axis"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(
            self,
            point_on_axis=vector(self.name, "point_on_axis", self.point_on_axis),
            direction=unit(self.name, "direction", self.direction),
            distance=number(self.name, "distance", self.distance, low=0.0),
            point=vector(self.name, "point", self.point),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self.point_on_axis, *tangents(self.direction).ravel(), self.distance]

"""Tasks for a point of the hand: at a place, at a distance from a point or an axis, on a plane.

What an object's symmetry leaves open, the task leaves free: a sphere takes one row, not three.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .aim_fields import across, number, rates, store, unit, vector
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED, TaskRows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .robot_state import RobotState

NO_DISTANCE = 1e-9
"""Distances below this have no direction, m: rounding of positions makes it arbitrary."""


def _origin() -> NDArray[np.float64]:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Position:
    """Bring a point of the hand to a goal: 3 rows.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    goal: NDArray[np.float64]
    """(3,), m, world."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """m/s."""
    name: str = "position"
    """Name for reports."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        store(
            self,
            goal=vector(self.name, "goal", self.goal),
            point=vector(self.name, "point", self.point),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the point's position, m, world."""
        position, jacobian = state.point(self.point)
        return TaskRows(self.name, position, self.goal - position, jacobian, self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class DistanceToPoint:
    """Bring a point of the hand to a distance from a centre, from any side: 1 row (eq. 4).

    The chapter prints the Jacobian of half the squared distance; with the unit normal instead a
    commanded speed is that speed. On the centre itself no direction leads away: there the row is
    that of the world axis along which the joints move the point best. With distance 0 it is still
    one row, which holds the distance only; :class:`Position` holds the point.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    centre: NDArray[np.float64]
    """(3,), m, world."""
    distance: float
    """Goal, m, at least 0."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """m/s."""
    name: str = "distance to point"
    """Name for reports."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        store(
            self,
            centre=vector(self.name, "centre", self.centre),
            distance=number(self.name, "distance", self.distance, low=0.0),
            point=vector(self.name, "point", self.point),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the distance, m."""
        position, jacobian = state.point(self.point)
        value, row = length_row(position - self.centre, jacobian)
        return _one_row(self.name, value, self.distance, row, self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class DistanceToAxis:
    """Bring a point of the hand to a distance from a line, at any place along and around it.

    1 row; 2 rows with distance 0, where the point comes onto the line: a distance has a kink
    there, the two coordinates across the line have none. With a distance, on the line itself the
    row is that of the direction across along which the joints move the point best.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    point_on_axis: NDArray[np.float64]
    """Any point of the line (3,), m, world."""
    direction: NDArray[np.float64]
    """Along the line (3,), world, of any length."""
    distance: float
    """Goal, m, at least 0."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """m/s."""
    name: str = "distance to axis"
    """Name for reports."""
    _across: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        direction = unit(self.name, "direction", self.direction)
        store(
            self,
            point_on_axis=vector(self.name, "point_on_axis", self.point_on_axis),
            direction=direction,
            distance=number(self.name, "distance", self.distance, low=0.0),
            point=vector(self.name, "point", self.point),
            _across=across(direction),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the distance, m; with distance 0, the place across the line (2,), m."""
        position, jacobian = state.point(self.point)
        offset = self._across @ (position - self.point_on_axis)
        rows = self._across @ jacobian
        if self.distance == 0.0:
            return TaskRows(self.name, offset, -offset, rows, self.gain, self.speed)
        value, row = length_row(offset, rows)
        return _one_row(self.name, value, self.distance, row, self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class PointOnPlane:
    """Bring a point of the hand onto a plane, at any place on it: 1 row.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    normal: NDArray[np.float64]
    """(3,), world, of any length."""
    offset: float
    """Distance of the plane from the world's origin along the normal, m; negative behind it."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """m/s."""
    name: str = "point on plane"
    """Name for reports."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        store(
            self,
            normal=unit(self.name, "normal", self.normal),
            offset=number(self.name, "offset", self.offset),
            point=vector(self.name, "point", self.point),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the point's coordinate along the normal, m."""
        position, jacobian = state.point(self.point)
        value = float(self.normal @ position)
        row = self.normal @ jacobian
        return _one_row(self.name, value, self.offset, row, self.gain, self.speed)


def length_row(
    offset: NDArray[np.float64], rows: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """Length of an offset (k,) with rows (k, n), and its derivative (n,).

    Where the length is 0 the derivative is that of the coordinate that moves best.
    """
    length = math.sqrt(offset @ offset)
    if length < NO_DISTANCE:
        return length, rows[int(np.argmax(np.einsum("ij,ij->i", rows, rows)))]
    return length, (offset / length) @ rows


def _one_row(
    name: str, value: float, goal: float, row: NDArray[np.float64], gain: float, speed: float
) -> TaskRows:
    return TaskRows(name, np.array([value]), np.array([goal - value]), row[None], gain, speed)

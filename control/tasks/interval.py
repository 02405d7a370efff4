"""A lower and an upper bound on the value of any task of one row."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..robot_state import RobotState
from .task import Task, TaskRows


@dataclass(frozen=True, eq=False)
class Interval:
    """Keep the value of a task of one row between two bounds; inside them it is free.

    There is no row while the nearer bound is farther than speed / gain (those of the task). Nearer
    to the bound there is one row with a side: the value may approach the bound at most at gain
    times the remaining distance. The stack drops the row while the other tasks respect this limit.
    So the motion neither crosses the bound nor starts abruptly at it. Outside the bounds, the row
    moves the value back. With equal bounds the task is an ordinary goal.

    Raises
    ------
    InputError
        If a bound is not a number, the lower is above the upper, both are infinite, or (by `at`)
        the task has more than one row.
    """

    task: Task
    """The task with the value, row, gain and speed. Its own goal has no effect."""
    low: float
    """Lower bound, units of the task's value; -inf: no bound."""
    high: float
    """Upper bound, units of the task's value; inf: no bound."""
    name: str = ""
    """Name for reports; if empty, that of the task."""

    def __post_init__(self) -> None:
        if not callable(getattr(self.task, "at", None)):
            raise InputError(f"interval: a task must have a method `at`, got {self.task!r}")
        name = self.name or self.task.name
        object.__setattr__(self, "name", name)
        try:
            low, high = float(self.low), float(self.high)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"{name}: low and high must be numbers, got {self.low!r} and {self.high!r}"
            ) from error
        if not low <= high or low == math.inf or high == -math.inf:
            raise InputError(f"{name}: the interval needs low <= high, got [{low}, {high}]")
        if math.isinf(low) and math.isinf(high):
            raise InputError(f"{name}: the interval needs a finite bound, got [{low}, {high}]")
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)

    def at(self, state: RobotState) -> TaskRows:
        """Return the row of the nearer bound, or no row far from it or if the task has none."""
        rows = self.task.at(state)
        if len(rows.value) == 0:
            return rows
        if len(rows.value) != 1:
            raise InputError(
                f"{self.name}: an interval needs a task of 1 row, {rows.name} has {len(rows.value)}"
            )
        return bounded(
            self.name,
            float(rows.value[0]),
            rows.jacobian,
            low=self.low,
            high=self.high,
            gain=rows.gain,
            speed=rows.speed,
        )


def bounded(
    name: str,
    value: float,
    jacobian: NDArray[np.float64],
    *,
    low: float,
    high: float,
    gain: float,
    speed: float,
) -> TaskRows:
    """Return the row that keeps a value with Jacobian (1, n) in [low, high]; see `Interval`."""
    m, side, error = bound(value, low, high, gain, speed)
    return TaskRows(name, np.full(m, value), np.full(m, error), jacobian[:m], gain, speed, side)


@njit(cache=True)
def bound(value, low, high, gain, speed):
    """Return the number of rows (0 or 1), side and error of a value to keep in [low, high]."""
    upper = high - value < value - low
    error = (high if upper else low) - value
    inside = error if upper else -error
    if low < high and inside * gain > speed:
        return 0, 0, error
    if low == high:
        return 1, 0, error
    return 1, -1 if upper else 1, error

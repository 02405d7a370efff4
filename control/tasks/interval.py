"""Two bounds on the value of any task of one row."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from eyehand.errors import InputError

from .task import TaskRows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..robot_state import RobotState
    from .task import Task


@dataclass(frozen=True, eq=False)
class Interval:
    """Keep the value of a task of one row between two bounds, and leave it free there.

    Well inside, there is no row. Within speed / gain of the nearer bound (both are the task's)
    there is one row with a side. The value may then approach the bound at no more than gain times
    the distance left, and the stack drops the row while the rest of the motion keeps to that. So
    nothing starts abruptly at the bound, and nothing crosses it. Outside, the row brings the value
    back. With equal bounds the task is a plain goal.

    Raises
    ------
    InputError
        If a bound is not a number, the lower is above the upper, both are infinite, or (by `at`)
        the task has more than one row.
    """

    task: Task
    """Gives value, row, gain and speed; its own goal does not matter."""
    low: float
    """Lower bound, units of the task's value; -inf: none."""
    high: float
    """Upper bound, units of the task's value; inf: none."""
    name: str = ""
    """Name for reports; that of the task when empty."""

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
        """Return the row of the bound; no row well inside, or where the inner task has none."""
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
    """Return the row that keeps a value with Jacobian (1, n) in [low, high], or no row inside."""
    m, side, error = bound(value, low, high, gain, speed)
    return TaskRows(name, np.full(m, value), np.full(m, error), jacobian[:m], gain, speed, side)


@njit(cache=True)
def bound(value, low, high, gain, speed):
    """Return number of rows (0 or 1), side and error of a value that has to stay in [low, high]."""
    upper = high - value < value - low
    error = (high if upper else low) - value
    inside = error if upper else -error
    if low < high and inside * gain > speed:
        return 0, 0, error
    if low == high:
        return 1, 0, error
    return 1, -1 if upper else 1, error

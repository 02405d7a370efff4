"""The task protocol, and the rows of a task: its value, error and Jacobian in one posture."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..robot_state import RobotState

DEFAULT_GAIN = 8.0
"""Default commanded velocity per error, 1/s: a small error falls by 95 % in 0.4 s. From the default
speed the hand slows down at 2 m/s², within the acceleration limits of common arms."""
DEFAULT_LINEAR_SPEED = 0.25
"""Default speed limit of a point, m/s: the reduced speed of ISO 10218-1 near people."""
DEFAULT_TURN_SPEED = 1.0
"""Default speed limit of a rotation, rad/s: at 0.25 m from the axis it is the linear limit."""


@dataclass(frozen=True, eq=False)
class TaskRows:
    """One task in one posture. Its index in the stack is its priority.

    A task may have no rows. Then it does not restrict the motion.

    Raises
    ------
    InputError
        If the shapes do not agree or a number is not finite.
    """

    name: str
    """Name for reports."""
    value: NDArray[np.float64]
    """Current value x(q), (m,)."""
    error: NDArray[np.float64]
    """Error, goal minus value, (m,)."""
    jacobian: NDArray[np.float64]
    """Rows J with dx/dt = J dq/dt, (m, n) (eq. 1)."""
    gain: float = 1.0
    """Commanded velocity per error, 1/s."""
    speed: float = math.inf
    """Maximum norm of the commanded velocity, units of the value per second."""
    side: int = 0
    """0: the value must move at `rate`. +1, at a lower bound: J dq/dt >= rate is sufficient.
    -1, at an upper bound: J dq/dt <= rate is sufficient. Only a task of one row may have a side."""

    def __post_init__(self) -> None:
        for what in ("value", "error", "jacobian"):
            try:
                array = np.asarray(getattr(self, what), dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError(f"task {self.name}: {what} must be numbers: {error}") from error
            # The dot product is finite only if all entries are. It is faster than np.isfinite.
            if not math.isfinite(np.vdot(array, array)):
                raise InputError(f"task {self.name}: {what} must be finite, got {array.tolist()}")
            object.__setattr__(self, what, array)
        rows = len(self.jacobian) if self.jacobian.ndim else 0
        if self.jacobian.ndim != 2 or self.value.shape != (rows,) or self.error.shape != (rows,):
            raise InputError(
                f"task {self.name}: jacobian (m, n), value (m,) and error (m,) must agree, got "
                f"{self.jacobian.shape}, {self.value.shape}, {self.error.shape}"
            )
        if not 0.0 < self.gain < math.inf:
            raise InputError(f"task {self.name}: gain must be finite and > 0, got {self.gain}")
        if not self.speed > 0.0:
            raise InputError(
                f"task {self.name}: speed must be > 0 (inf: no limit), got {self.speed}"
            )
        if self.side not in (-1, 0, 1) or (self.side and rows > 1):
            raise InputError(
                f"task {self.name}: side must be -1, 0 or 1, and 0 with more than one row, got "
                f"{self.side} with {rows} rows"
            )

    @property
    def rate(self) -> NDArray[np.float64]:
        """Commanded velocity of the value (m,): gain times error, limited to the norm `speed`."""
        rate = self.gain * self.error
        if self.speed == math.inf:
            return rate
        norm = math.sqrt(np.vdot(rate, rate))
        return rate if norm <= self.speed else rate * (self.speed / norm)

    @property
    def unmet(self) -> float:
        """Norm of the error; 0 for a one-sided task on the allowed side of its bound."""
        if self.side and len(self.error):
            return max(0.0, self.side * float(self.error[0]))
        return math.sqrt(np.vdot(self.error, self.error))


class Task(Protocol):
    """A goal of the motion. `at` returns its rows in a posture.

    Tasks check their fields at construction, so that `at` is fast. A task with a true attribute
    `endless` never ends: a motion counts as reached even if such a task has an error.
    """

    @property
    def name(self) -> str:
        """Name for reports."""
        ...

    def at(self, state: RobotState) -> TaskRows:
        """Return the rows in this posture; their number may depend on the posture."""
        ...

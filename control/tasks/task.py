"""Tasks: what a motion should achieve, as an error and the Jacobian rows that reduce it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..robot_state import RobotState

DEFAULT_GAIN = 3.0
"""Share of the error taken away per second, 1/s: 95 % of a small error is gone after a second."""
DEFAULT_LINEAR_SPEED = 0.25
"""Largest commanded speed of a point, m/s: the reduced speed of ISO 10218-1 beside people."""
DEFAULT_TURN_SPEED = 1.0
"""Largest commanded speed of a turn, rad/s: the linear speed, at 0.25 m from the axis."""


@dataclass(frozen=True, eq=False)
class TaskRows:
    """One task in one posture; its priority is its place in the stack.

    A task without rows is legal: it is released and asks for nothing.

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
    """Largest norm of the commanded velocity, units of the value per second."""
    side: int = 0
    """0: the value shall move at `rate`. +1: at a lower bound, J dq/dt >= rate is enough;
    -1: at an upper bound, J dq/dt <= rate is enough. Only tasks of one row have a side."""

    def __post_init__(self) -> None:
        for what in ("value", "error", "jacobian"):
            try:
                array = np.asarray(getattr(self, what), dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError(f"task {self.name}: {what} must be numbers: {error}") from error
            # One dot product is finite exactly when all entries are, and costs a third of asking.
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
            raise InputError(f"task {self.name}: speed must be > 0 (inf: none), got {self.speed}")
        if self.side not in (-1, 0, 1) or (self.side and rows > 1):
            raise InputError(
                f"task {self.name}: side must be -1, 0 or 1, and 0 with more than one row, got "
                f"{self.side} with {rows} rows"
            )

    @property
    def rate(self) -> NDArray[np.float64]:
        """Commanded velocity of the value, (m,): gain times error, cut to the norm `speed`."""
        rate = self.gain * self.error
        if self.speed == math.inf:
            return rate
        norm = math.sqrt(np.vdot(rate, rate))
        return rate if norm <= self.speed else rate * (self.speed / norm)

    @property
    def unmet(self) -> float:
        """Norm of the error that counts: 0 for a one-sided task on the allowed side."""
        if self.side and len(self.error):
            return max(0.0, self.side * float(self.error[0]))
        return math.sqrt(np.vdot(self.error, self.error))


class Task(Protocol):
    """What to reach, for any posture: `at` gives the task in the current one.

    Tasks check what they are given when they are made, so that `at` is fast. One with a true
    attribute `endless` only draws: a motion counts as reached without it.
    """

    @property
    def name(self) -> str:
        """Name for reports."""
        ...

    def at(self, state: RobotState) -> TaskRows:
        """The task in this posture; its number of rows may change from posture to posture."""
        ...

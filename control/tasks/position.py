"""The task that brings a point of the hand to a position: three rows."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .inputs import check_gain_and_speed, origin, store, vector
from .kernel_task import FIELDS, SPEED, KernelTask, moved_point
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED


@njit(cache=True)
def position_rows(task, frame, out):
    """Fill the rows of `Position`; parameters: goal (3,)."""
    point = moved_point(task, frame)
    for axis in range(3):
        out.value[axis] = point[axis]
        out.error[axis] = task[FIELDS + axis] - point[axis]
        out.rows[axis] = frame.work[axis]
    return 3, 0, task[SPEED]


@dataclass(frozen=True, eq=False)
class Position(KernelTask):
    """Bring a point of the hand to a goal: 3 rows. The value is the point's position, m, world.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    kernel: ClassVar = staticmethod(position_rows)

    goal: NDArray[np.float64]
    """Goal position (3,), m, world."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """Speed limit, m/s."""
    name: str = "position"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(
            self,
            goal=vector(self.name, "goal", self.goal),
            point=vector(self.name, "point", self.point),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self.goal]

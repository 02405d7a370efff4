"""The task that brings a point of the hand onto a plane: one row."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .inputs import check_gain_and_speed, number, origin, store, unit, vector
from .kernel_task import FIELDS, SPEED, KernelTask, moved_point
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED


@njit(cache=True)
def point_on_plane_rows(task, frame, out):
    """Fill the row of `PointOnPlane`; parameters: normal (3,), offset."""
    x, y, z = moved_point(task, frame)
    a, b, c = task[FIELDS], task[FIELDS + 1], task[FIELDS + 2]
    out.value[0] = a * x + b * y + c * z
    out.error[0] = task[FIELDS + 3] - out.value[0]
    linear = frame.work
    for column in range(linear.shape[1]):
        out.rows[0, column] = a * linear[0, column] + b * linear[1, column] + c * linear[2, column]
    return 1, 0, task[SPEED]


@dataclass(frozen=True, eq=False)
class PointOnPlane(KernelTask):
    """Bring a point of the hand onto a plane, anywhere on it: 1 row.

    The value is the point's coordinate along the normal, m.

    Raises
    ------
    InputError
        If a field has the wrong shape, is not finite, or is out of its range.
    """

    kernel: ClassVar = staticmethod(point_on_plane_rows)

    normal: NDArray[np.float64]
    """(3,), world, of any length."""
    offset: float
    """Coordinate of the plane along the normal, m, from the world's origin."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """Speed limit, m/s."""
    name: str = "point on plane"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(
            self,
            normal=unit(self.name, "normal", self.normal),
            offset=number(self.name, "offset", self.offset),
            point=vector(self.name, "point", self.point),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self.normal, self.offset]

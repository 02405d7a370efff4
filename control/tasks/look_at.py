"""The task that keeps a target in a cone about an axis of the hand: one or two rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .direction import direction_rows, polar_row
from .inputs import check_gain_and_speed, number, origin, store, tangents, unit, vector
from .interval import bound
from .kernel_task import FIELDS, GAIN, SPEED, KernelTask, moved_point
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED

MIN_TARGET_DISTANCE = 1e-3
"""Minimum distance to the target, m. Nearer, the task has no rows: a millimetre of motion would
reverse the direction to the target."""


@njit(cache=True)
def look_at_rows(task, frame, out):
    """Fill the rows of `LookAt`; parameters: tangents (2, 3), axis and target (3,), half angle."""
    fields, axes, jacobian = task[FIELDS:], frame.axes, frame.jacobian
    linear, motion = frame.work[:3], frame.work[3:]
    x, y, z = moved_point(task, frame)
    x, y, z = fields[9] - x, fields[10] - y, fields[11] - z
    distance = math.sqrt(x * x + y * y + z * z)
    if distance < MIN_TARGET_DISTANCE:
        return 0, 0, task[SPEED]
    x, y, z = x / distance, y / distance, z / distance
    # In the controlled frame the axis is fixed, and the direction to the target moves.
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        u, v, w = linear[0, column], linear[1, column], linear[2, column]
        along = x * u + y * v + z * w
        u = (x * along - u) / distance + y * c - z * b
        v = (y * along - v) / distance + z * a - x * c
        w = (z * along - w) / distance + x * b - y * a
        for axis in range(3):
            motion[axis, column] = axes[axis] * u + axes[3 + axis] * v + axes[6 + axis] * w
    view = (
        axes[0] * x + axes[3] * y + axes[6] * z,
        axes[1] * x + axes[4] * y + axes[7] * z,
        axes[2] * x + axes[5] * y + axes[8] * z,
    )
    if fields[12] == 0.0:
        direction_rows(view, motion, fields[6:9], fields[:6], out.value, out.rows)
        out.error[0], out.error[1] = -out.value[0], -out.value[1]
        return 2, 0, task[SPEED]
    _, _, angle, _ = polar_row(view, motion, fields[6:9], fields[:6], out.rows)
    out.value[0] = angle
    m, side, out.error[0] = bound(angle, -np.inf, fields[12], task[GAIN], task[SPEED])
    return m, side, task[SPEED]


def _forward() -> NDArray[np.float64]:
    return np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class LookAt(KernelTask):
    """Keep a target in a cone about an axis of the hand: 1 row, or 2 if the half angle is 0.

    With a half angle of 0, the axis points at the target. The value is then two angles from the
    axis to the target (2,), rad. With a larger half angle, the value is the angle between axis and
    target (1,). It is one-sided like :class:`Interval`, with no row well inside the cone. Both
    rotation and translation of the eye change the direction to the target. Nearer to the target
    than a millimetre there are no rows.

    Raises
    ------
    InputError
        If a direction has no length, or a number is not finite or out of its range.
    """

    kernel: ClassVar = staticmethod(look_at_rows)

    target: NDArray[np.float64]
    """(3,), m, world."""
    half_angle: float = 0.0
    """Maximum angle between axis and target, rad, in [0, π]."""
    axis: NDArray[np.float64] = field(default_factory=_forward)
    """Viewing direction of the hand (3,), in the controlled frame, of any length."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """Position of the eye (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Speed limit, rad/s."""
    name: str = "look at"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(
            self,
            target=vector(self.name, "target", self.target),
            half_angle=number(self.name, "half_angle", self.half_angle, low=0.0, high=math.pi),
            axis=unit(self.name, "axis", self.axis),
            point=vector(self.name, "point", self.point),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*tangents(self.axis).ravel(), *self.axis, *self.target, self.half_angle]

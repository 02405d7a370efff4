"""The task that aligns an axis of the hand with a direction: two rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .direction import direction_rows
from .inputs import check_gain_and_speed, store, tangents, unit
from .kernel_task import FIELDS, SPEED, KernelTask
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED


@njit(cache=True)
def axis_alignment_rows(task, frame, out):
    """Fill the rows of `AxisAlignment`; parameters: tangents (2, 3), goal (3,), axis (3,)."""
    fields, axes, jacobian, motion = task[FIELDS:], frame.axes, frame.jacobian, frame.work[3:]
    basis, goal, axis = fields[:6], fields[6:9], fields[9:12]
    x = axes[0] * axis[0] + axes[1] * axis[1] + axes[2] * axis[2]
    y = axes[3] * axis[0] + axes[4] * axis[1] + axes[5] * axis[2]
    z = axes[6] * axis[0] + axes[7] * axis[1] + axes[8] * axis[2]
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        motion[0, column] = b * z - c * y
        motion[1, column] = c * x - a * z
        motion[2, column] = a * y - b * x
    direction_rows((x, y, z), motion, goal, basis, out.value, out.rows)
    out.error[0], out.error[1] = -out.value[0], -out.value[1]
    return 2, 0, task[SPEED]


@dataclass(frozen=True, eq=False)
class AxisAlignment(KernelTask):
    """Align an axis of the hand with a direction: 2 rows. The rotation about the axis stays free.

    The value (2,), rad, has the angle between axis and goal as its norm. Its direction points from
    the goal to the axis, in the basis of two fixed unit vectors perpendicular to the goal. If the
    axis is opposite to the goal, the direction of rotation is not unique. The task then
    selects the basis vector along which the joints move the axis best. It rotates in the plane of
    the goal and this vector.

    Raises
    ------
    InputError
        If a direction has no length, or a number is not finite or out of its range.
    """

    kernel: ClassVar = staticmethod(axis_alignment_rows)

    axis: NDArray[np.float64]
    """(3,), in the controlled frame, of any length; stored as a unit vector."""
    goal: NDArray[np.float64]
    """(3,), world, of any length; stored as a unit vector."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Speed limit, rad/s."""
    name: str = "axis alignment"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        goal = unit(self.name, "goal", self.goal)
        store(self, axis=unit(self.name, "axis", self.axis), goal=goal)

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*tangents(self.goal).ravel(), *self.goal, *self.axis]

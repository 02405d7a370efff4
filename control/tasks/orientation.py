"""The task that rotates the hand to an orientation: three rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from .inputs import check_gain_and_speed, rotation, store
from .kernel_task import FIELDS, SPEED, KernelTask
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED

HALF_TURN_TOLERANCE = 1e-9
"""Tolerance of half a turn. A quaternion (w, v) beyond half a turn has w < 0. Down to minus this
share of |v|, w counts as zero."""


@njit(cache=True)
def orientation_rows(task, frame, out):
    """Fill the rows of `Orientation`; parameters: goal (9,), row by row."""
    rotation_rows(task[FIELDS:], frame, out.error, out.rows)
    for row in range(3):
        out.value[row] = -out.error[row]
    return 3, 0, task[SPEED]


@njit(cache=True)
def rotation_rows(goal, frame, error, rows):
    """Fill the rotation vector e from the frame to its goal (9,), and the Jacobian of -e.

    With e = log(goal frameᵀ), θ = |e| and the frame's angular Jacobian, -de/dq = Jr(e)⁻¹ angular,
    where Jr⁻¹ = 1 + [e]/2 + (1 - (θ/2) cot(θ/2))/θ² [e]² (Chirikjian 2012, Stochastic Models 2,
    10.86).
    """
    x, y, z = _rotation_vector(goal, frame.axes)
    error[0], error[1], error[2] = x, y, z
    angle = math.sqrt(x * x + y * y + z * z)
    # For small angles the closed form loses digits, and the first term of its
    # series is exact to rounding error.
    if angle < 1e-3:
        factor = 1.0 / 12.0
    else:
        factor = (1.0 - angle / 2.0 / math.tan(angle / 2.0)) / angle**2
    jacobian = frame.jacobian
    for column in range(jacobian.shape[1]):
        wx, wy, wz = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        cx, cy, cz = y * wz - z * wy, z * wx - x * wz, x * wy - y * wx
        rows[0, column] = wx + 0.5 * cx + factor * (y * cz - z * cy)
        rows[1, column] = wy + 0.5 * cy + factor * (z * cx - x * cz)
        rows[2, column] = wz + 0.5 * cz + factor * (x * cy - y * cx)


@njit(cache=True)
def _rotation_vector(goal, axes):
    """Return the rotation vector of goal times axesᵀ, at any angle up to π (Shepperd 1978)."""
    a = goal[0] * axes[0] + goal[1] * axes[1] + goal[2] * axes[2]
    b = goal[0] * axes[3] + goal[1] * axes[4] + goal[2] * axes[5]
    c = goal[0] * axes[6] + goal[1] * axes[7] + goal[2] * axes[8]
    d = goal[3] * axes[0] + goal[4] * axes[1] + goal[5] * axes[2]
    e = goal[3] * axes[3] + goal[4] * axes[4] + goal[5] * axes[5]
    f = goal[3] * axes[6] + goal[4] * axes[7] + goal[5] * axes[8]
    g = goal[6] * axes[0] + goal[7] * axes[1] + goal[8] * axes[2]
    h = goal[6] * axes[3] + goal[7] * axes[4] + goal[8] * axes[5]
    i = goal[6] * axes[6] + goal[7] * axes[7] + goal[8] * axes[8]
    trace = a + e + i
    if trace >= max(a, e, i):
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif a >= max(e, i):
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif e >= i:
        w, x, y, z = c - g, b + d, 1.0 - a + e - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 - a - e + i
    sine = math.sqrt(x * x + y * y + z * z)
    # At half a turn, rounding must not select the direction of rotation.
    if w < -HALF_TURN_TOLERANCE * sine:
        w, x, y, z = -w, -x, -y, -z
    stretch = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 0.0
    return x * stretch, y * stretch, z * stretch


@dataclass(frozen=True, eq=False)
class Orientation(KernelTask):
    """Rotate the controlled frame to a goal: 3 rows.

    The error is the rotation vector from the frame to the goal, in world axes. The value is its
    negative. The rows are the exact derivative of the value: the inverse right Jacobian of the
    rotation group times the angular Jacobian. This inverse Jacobian maps the rotation
    vector to itself, so the commanded rotation is about this vector. At half a turn both directions
    are equally short. The task uses the vector whose largest coordinate is positive.

    Raises
    ------
    InputError
        If the goal is not a rotation, or a number is not finite or out of its range.
    """

    kernel: ClassVar = staticmethod(orientation_rows)

    goal: Rotation | NDArray[np.float64]
    """Goal orientation of the controlled frame in the world: a rotation, or its matrix (3, 3)."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Speed limit, rad/s."""
    name: str = "orientation"
    """Name for reports."""
    _goal: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(self, _goal=rotation(self.name, "goal", self.goal))

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self._goal.ravel()]

"""The task that brings the hand to a pose: six rows."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from .inputs import check_gain_and_speed, origin, rotation, store, transform, vector
from .kernel_task import FIELDS, GAIN, SPEED, KernelTask, moved_point
from .orientation import rotation_rows
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED, DEFAULT_TURN_SPEED


@njit(cache=True)
def pose_rows(task, frame, out):
    """Fill the rows of `Pose`; parameters: rotation (9,), position (3,), angular speed limit.

    The returned speed limit of all six coordinates respects the linear and the angular limit.
    """
    fields, gain = task[FIELDS:], task[GAIN]
    point = moved_point(task, frame)
    square = 0.0
    for axis in range(3):
        out.value[axis] = point[axis]
        out.error[axis] = fields[9 + axis] - point[axis]
        square += out.error[axis] * out.error[axis]
        out.rows[axis] = frame.work[axis]
    rotation_rows(fields, frame, out.error[3:], out.rows[3:])
    turn = 0.0
    for row in range(3, 6):
        out.value[row] = -out.error[row]
        turn += out.error[row] * out.error[row]
    excess = gain * max(math.sqrt(square) / task[SPEED], math.sqrt(turn) / fields[12])
    if excess > 1.0:
        return 6, 0, gain * math.sqrt(square + turn) / excess
    return 6, 0, np.inf


@dataclass(frozen=True, eq=False)
class Pose(KernelTask):
    """Bring the controlled frame to a goal: 6 rows, position (m) first, then orientation (rad).

    The value is the position of the point, and then the rotation vector from the goal to the frame,
    both in world axes. The whole motion slows down until neither speed limit is exceeded. So
    position and orientation arrive together.

    Raises
    ------
    InputError
        If the goal is not a pose, or a number is not finite or out of its range.
    """

    kernel: ClassVar = staticmethod(pose_rows)

    goal: RigidTransform | NDArray[np.float64]
    """Goal pose (T_world_frame): a transform, or its matrix (4, 4)."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point to bring to the position of the goal (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """Linear speed limit, m/s."""
    turn_speed: float = DEFAULT_TURN_SPEED
    """Angular speed limit, rad/s."""
    name: str = "pose"
    """Name for reports."""
    _position: NDArray[np.float64] = field(init=False, repr=False)
    _rotation: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        check_gain_and_speed(self.name, self.gain, self.turn_speed)
        matrix = transform(self.name, "goal", self.goal)
        store(
            self,
            point=vector(self.name, "point", self.point),
            _position=vector(self.name, "goal's position", matrix[:3, 3]),
            _rotation=rotation(self.name, "goal's rotation", matrix[:3, :3]),
        )

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        return [*self._rotation.ravel(), *self._position, self.turn_speed]

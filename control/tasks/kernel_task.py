"""The common form of the built-in tasks: one compiled kernel computes value, error and Jacobian.

A kernel takes ``(task, frame, out)``: the task as a row of numbers (:func:`pack`), the robot's
:class:`Frame` and the :class:`Output` to fill. It returns the number of rows m, the side (see
:class:`TaskRows`) and the speed limit of the commanded velocity. `KernelTask.at` calls the kernel
for one task. The control cycle calls the same kernel through :mod:`registry`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..robot_state import RobotState
from .task import TaskRows

KIND, GAIN, SPEED, BOUNDED, LOW, HIGH, POINT, FIELDS = 0, 1, 2, 3, 4, 5, 6, 9
"""Columns of a packed task: kind (see :mod:`registry`), gain, speed, 1 if the task is inside an
:class:`Interval`, the two bounds of the interval, point in the controlled frame (3,). The
parameters of the kernel start at column FIELDS."""
TASK_ROWS = 6
"""Maximum number of rows of a task whose size does not depend on the number of joints (a pose)."""


class Frame(NamedTuple):
    """The joints and the controlled frame in one posture, for kernels."""

    q: NDArray[np.float64]
    """(n,), rad or m."""
    limits: NDArray[np.float64]
    """(n, 3): lower and upper joint limit, joint speed limit."""
    position: NDArray[np.float64]
    """Origin (3,), m, world."""
    axes: NDArray[np.float64]
    """Axes of the frame: the rotation matrix from frame to world, row by row (9,)."""
    jacobian: NDArray[np.float64]
    """(6, n) of the origin, rows [v; ω], world axes."""
    work: NDArray[np.float64]
    """Scratch memory (6, n): first the linear Jacobian of a point, then that of a direction."""


class Output(NamedTuple):
    """The output of a kernel. M is max(6, n); a task of m rows uses the first m entries."""

    value: NDArray[np.float64]
    """(M,)."""
    error: NDArray[np.float64]
    """(M,)."""
    rows: NDArray[np.float64]
    """Jacobian (M, n)."""


class KernelTask(ABC):
    """A task computed by a compiled kernel. A subclass is a frozen dataclass.

    A subclass has the fields `name`, `gain` and `speed`, and defines `kernel` and `parameters`.
    """

    kernel: ClassVar[Callable[..., Any]]
    """The kernel, wrapped in `staticmethod`."""
    name: str
    gain: float
    speed: float

    @abstractmethod
    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel, in its order.

        Raises
        ------
        InputError
            If the task does not fit a robot with this number of joints.
        """

    def at(self, state: RobotState) -> TaskRows:
        """Return value, error and Jacobian in one posture."""
        n = len(state.q)
        size = max(TASK_ROWS, n)
        out = Output(np.empty(size), np.empty(size), np.empty((size, n)))
        frame = Frame(
            np.ascontiguousarray(state.q, dtype=np.float64),
            np.column_stack([state.lower, state.upper, state.speed]).astype(np.float64),
            np.ascontiguousarray(state.position, dtype=np.float64),
            np.ravel(state.rotation).astype(np.float64),
            np.ascontiguousarray(state.jacobian, dtype=np.float64),
            np.empty((6, n)),
        )
        m, side, speed = type(self).kernel(pack(self, n), frame, out)
        return TaskRows(
            self.name, out.value[:m], out.error[:m], out.rows[:m], self.gain, speed, side
        )


def pack(task: KernelTask, joints: int) -> NDArray[np.float64]:
    """Return a task as a row of numbers; kind and bounds are 0, and :mod:`registry` sets them.

    Raises
    ------
    InputError
        If the task does not fit this number of joints.
    """
    parameters = task.parameters(joints)
    row = np.zeros(FIELDS + len(parameters))
    row[GAIN], row[SPEED] = task.gain, task.speed
    row[POINT:FIELDS] = getattr(task, "point", 0.0)
    row[FIELDS:] = parameters
    return row


@njit(cache=True)
def moved_point(task, frame):
    """Return the position (x, y, z) of the task's point in the world, m.

    The Jacobian of the point is written to ``frame.work[:3]``.
    """
    axes, jacobian, linear = frame.axes, frame.jacobian, frame.work
    a, b, c = task[POINT], task[POINT + 1], task[POINT + 2]
    x = axes[0] * a + axes[1] * b + axes[2] * c
    y = axes[3] * a + axes[4] * b + axes[5] * c
    z = axes[6] * a + axes[7] * b + axes[8] * c
    for column in range(jacobian.shape[1]):
        wx, wy, wz = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        linear[0, column] = jacobian[0, column] + wy * z - wz * y
        linear[1, column] = jacobian[1, column] + wz * x - wx * z
        linear[2, column] = jacobian[2, column] + wx * y - wy * x
    return frame.position[0] + x, frame.position[1] + y, frame.position[2] + z

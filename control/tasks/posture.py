"""The task that moves the joints to given positions: n rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .inputs import check_gain_and_speed, check_joint_count, store, vector
from .kernel_task import FIELDS, SPEED, KernelTask
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED


@njit(cache=True)
def posture_rows(task, frame, out):
    """Fill the rows of `Posture`; parameters: goal (n,)."""
    n = len(frame.q)
    joint_rows(frame.q, out)
    for joint in range(n):
        out.error[joint] = task[FIELDS + joint] - frame.q[joint]
    return n, 0, task[SPEED]


@njit(cache=True)
def joint_rows(q, out):
    """Fill value and rows of a task whose value is the joint positions."""
    n = len(q)
    out.rows[:n] = 0.0
    for joint in range(n):
        out.value[joint] = q[joint]
        out.rows[joint, joint] = 1.0


@dataclass(frozen=True, eq=False)
class Posture(KernelTask):
    """Move the joints to given positions: n rows. The value is q (n,), rad or m.

    Tasks below it have no effect, because no joint motion is left free.

    Raises
    ------
    InputError
        If the goal is not finite, or (by `at`) its length is not the number of joints.
    """

    kernel: ClassVar = staticmethod(posture_rows)

    goal: NDArray[np.float64]
    """Joint positions (n,), rad or m."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Upper limit of the norm of the joint velocities, rad/s."""
    name: str = "posture"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        store(self, goal=vector(self.name, "goal", self.goal, None))

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        check_joint_count(self.name, "goal", self.goal, joints)
        return [*self.goal]

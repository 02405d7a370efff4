"""The task that moves joints to the middle of their ranges or to a posture: n rows (eq. 5)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

from .inputs import check_gain_and_speed, check_joint_count, store, vector
from .kernel_task import FIELDS, SPEED, KernelTask
from .posture import joint_rows
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED


@njit(cache=True)
def joint_centring_rows(task, frame, out):
    """Fill the rows of `JointCentring`; parameters: power, 1 with a reference, reference (n,)."""
    n = len(frame.q)
    joint_rows(frame.q, out)
    given = task[FIELDS + 1] != 0.0
    for joint in range(n):
        reference = task[FIELDS + 2 + joint] if given else np.nan
        slope = centring_slope(frame.q[joint], frame.limits[joint], task[FIELDS], reference)
        out.error[joint] = -slope
    return n, 0, task[SPEED]


@njit(cache=True)
def centring_slope(q, limits, power, reference):
    """Return the derivative of a joint's cost of eq. (5); 0 for a joint without a range.

    ``limits`` are the lower and upper limit. A reference of NaN means their middle.
    """
    width = limits[1] - limits[0]
    if not 0.0 < width < np.inf:
        return 0.0
    away = q - (0.5 * (limits[0] + limits[1]) if math.isnan(reference) else reference)
    return power * (away ** int(power - 1) / width)


@dataclass(frozen=True, eq=False)
class JointCentring(KernelTask):
    """Move the joints towards a reference posture by gradient descent on eq. (5): n rows.

    The cost is H = Σ wᵢ (qᵢ - refᵢ)^p with wᵢ = 1 / range. The value is q and the error is -∇H. So
    the commanded motion is -gain ∇H, as far as the tasks above allow it. A single row on H would
    command more and more speed where those tasks keep H from falling. The task uses all free joint
    motion, so put it last. It never ends: a motion counts as reached without it, unless
    there is no other task. Joints without a range are not moved.

    Raises
    ------
    InputError
        If the power is not even (H would have no minimum), the reference is not finite, or (by
        `at`) its length is not the number of joints.
    """

    kernel: ClassVar = staticmethod(joint_centring_rows)

    power: int = 2
    """Power p, even and at least 2. A higher power acts less near the middle, and more near the
    limits."""
    reference: NDArray[np.float64] | None = None
    """Reference posture (n,), rad or m; None: the middle of the ranges."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Upper limit of the norm of the joint velocities, rad/s."""
    name: str = "joint centring"
    """Name for reports."""
    endless: ClassVar[bool] = True
    """The task never ends, see :class:`Task`."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
        power = self.power
        if isinstance(power, bool) or not isinstance(power, int) or power < 2 or power % 2:
            raise InputError(
                f"{self.name}: power must be an even whole number >= 2 (eq. 5 has no minimum with "
                f"an odd one), got {power!r}"
            )
        if self.reference is not None:
            store(self, reference=vector(self.name, "reference", self.reference, None))

    def parameters(self, joints: int) -> list[float]:
        """Return the parameters of the kernel."""
        if self.reference is None:
            return [self.power, 0.0]
        check_joint_count(self.name, "reference", self.reference, joints)
        return [self.power, 1.0, *self.reference]

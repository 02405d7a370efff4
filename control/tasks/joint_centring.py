"""Joints near the middle of their ranges, or near a reference posture: n rows (eq. 5)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numba import njit

from eyehand.errors import InputError

from .inputs import fits_joints, rates, store, vector
from .kernel_task import FIELDS, SPEED, KernelTask
from .posture import joint_rows
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED

if TYPE_CHECKING:
    from numpy.typing import NDArray


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
    """Return the slope of a joint's cost of eq. (5), 0 for a joint without a range.

    ``limits`` are its lower and upper limit. A NaN as reference means their middle.
    """
    width = limits[1] - limits[0]
    if not 0.0 < width < np.inf:
        return 0.0
    away = q - (0.5 * (limits[0] + limits[1]) if math.isnan(reference) else reference)
    return power * (away ** int(power - 1) / width)


@dataclass(frozen=True, eq=False)
class JointCentring(KernelTask):
    """Draw the joints to a reference posture: the descent of eq. (5), n rows.

    H = Σ wᵢ (qᵢ - refᵢ)^p with wᵢ = 1 / range. The value is the posture itself and the error -∇H,
    so that the commanded motion is -gain ∇H in what the tasks above leave free. As one row on H it
    would ask for ever more speed where those tasks keep H from falling. It uses all that is left
    free, so put it last. It never ends a motion: a motion counts as reached without it, unless
    there is no other task. Joints without a range stay as they are.

    Raises
    ------
    InputError
        If the power is not even (H would fall without end on one side), the reference is not
        finite, or (by `at`) it has not one number per joint.
    """

    kernel: ClassVar = staticmethod(joint_centring_rows)

    power: int = 2
    """Even, at least 2: higher leaves the middle free and pushes harder near the limits."""
    reference: NDArray[np.float64] | None = None
    """Reference posture (n,), rad or m; the middle of the ranges when None."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Upper limit of the norm of the joint velocities, rad/s."""
    name: str = "joint centring"
    """Name for reports."""
    endless: ClassVar[bool] = True
    """It never ends a motion, see :class:`Task`."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        power = self.power
        if isinstance(power, bool) or not isinstance(power, int) or power < 2 or power % 2:
            raise InputError(
                f"{self.name}: power must be an even whole number >= 2 (eq. 5 has no minimum with "
                f"an odd one), got {power!r}"
            )
        if self.reference is not None:
            store(self, reference=vector(self.name, "reference", self.reference, None))

    def parameters(self, joints: int) -> list[float]:
        """Return what the kernel reads."""
        if self.reference is None:
            return [self.power, 0.0]
        fits_joints(self.name, "reference", self.reference, joints)
        return [self.power, 1.0, *self.reference]

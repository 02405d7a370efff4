"""Checks of measured joint positions: far outside the limits, or faster than the arm can move."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from numba import njit

from eyehand.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .robot_model import RobotModel

BEYOND_LIMITS = 0.5
"""Distance beyond a joint limit up to which a position is accepted, rad or m. The arm then returns
to its range. A larger one is a wrong unit, a wrong order of joints, or a wrong encoder turn."""
MAX_POSITION = 1e4
"""Maximum position of a joint without limits, rad or m."""
JUMP_CYCLES = 10
"""Number of cycles at full speed that a joint may move between two calls: late cycles, and encoders
read at another time than the command is sent."""
JUMP = 0.02
"""Change of a joint between two calls that is always accepted, rad or m: noise of encoders."""


@njit(cache=True)
def posture_fault(q, last, limits, dt):
    """Return the first joint in fault: 1 + joint if outside its range, -1 - joint if it jumped.

    Return 0 for none.

    Parameters
    ----------
    q, last
        Joint positions (n,) now and one cycle before; NaN if they are not known.
    limits
        (n, 5), see `RobotModel.limits`.
    dt
        Control period, s.
    """
    for joint in range(len(q)):
        low = max(limits[joint, 0] - BEYOND_LIMITS, -MAX_POSITION)
        high = min(limits[joint, 1] + BEYOND_LIMITS, MAX_POSITION)
        if not low <= q[joint] <= high:
            return 1 + joint
    for joint in range(len(q)):
        if abs(q[joint] - last[joint]) > JUMP_CYCLES * dt * limits[joint, 2] + JUMP:
            return -1 - joint
    return 0


def jump_reason(
    fault: int, q: NDArray[np.float64], last: NDArray[np.float64], robot: RobotModel, dt: float
) -> str:
    """Return what is wrong with a posture in fault, if it is a jump.

    Raises
    ------
    InputError
        If a joint is outside its range.
    """
    joint = abs(fault) - 1
    name, value = robot.joint_names[joint], float(q[joint])
    if fault < 0:
        allowed = JUMP_CYCLES * dt * robot.speed[joint] + JUMP
        return (
            f"joint {name} jumped by {value - last[joint]:.3g} rad or m in one cycle; "
            f"its speed limit allows {allowed:.2g}"
        )
    low, high = float(robot.lower[joint]), float(robot.upper[joint])
    if not math.isfinite(high - low):
        raise InputError(f"joint {name} must be within ±{MAX_POSITION:g} rad or m, got {value:.6g}")
    raise InputError(
        f"joint {name} must be in [{low:.4g}, {high:.4g}] rad or m, or at most {BEYOND_LIMITS:g} "
        f"outside, got {value:.6g}"
    )

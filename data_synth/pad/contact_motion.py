"""Poses and velocities of solids in the pad's frame, and limits of friction (compiled)."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from .foam_column import FRICTION, LOSS_TIME, SLIP_SPEED

POSE_FIELDS = 13
"""Number of fields of a stored pose: rotation row by row (9), position (3), 1.0 if it is valid."""

_GRIP_MARGIN = 4.0
"""The slip speed is at least this many times the change of speed that full friction makes in one
step."""
_MAX_DAMPING = 0.6
"""Maximum share of a body's velocity that damping may remove in one step."""


@njit(cache=True, error_model="numpy")
def to_pad_frame(pad, position, rotation, R_pad_solid, p_pad_solid):
    """Convert a pose from the world to the pad's frame.

    Parameters
    ----------
    pad
        :class:`PadPose`.
    position, rotation
        (3,) m and (9,) row by row: the pose in the world.
    R_pad_solid, p_pad_solid
        (3, 3) and (3,) m, overwritten.
    """
    for i in range(3):
        total = 0.0
        for m in range(3):
            total += pad.rotation[3 * m + i] * (position[m] - pad.position[m])
        p_pad_solid[i] = total
        for j in range(3):
            total = 0.0
            for m in range(3):
                total += pad.rotation[3 * m + i] * rotation[3 * m + j]
            R_pad_solid[i, j] = total


@njit(cache=True, error_model="numpy")
def twist_since(R_pad_solid, p_pad_solid, last_pose, dt, twist):
    """Compute velocity at the pad's origin and angular velocity (6,), in the pad's frame.

    The difference of two poses is right for driven, placed and free bodies alike. It equals the
    velocity that a semi-implicit step has used.
    """
    twist[:] = 0.0
    if dt <= 0.0 or last_pose[12] == 0.0:
        return
    change = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            total = 0.0
            for m in range(3):
                total += R_pad_solid[i, m] * last_pose[3 * j + m]
            change[i, j] = total
    for i in range(3):
        carried = 0.0
        for m in range(3):
            carried += change[i, m] * last_pose[9 + m]
        twist[i] = (p_pad_solid[i] - carried) / dt
    twist[3] = 0.5 * (change[2, 1] - change[1, 2]) / dt
    twist[4] = 0.5 * (change[0, 2] - change[2, 0]) / dt
    twist[5] = 0.5 * (change[1, 0] - change[0, 1]) / dt


@njit(cache=True, error_model="numpy")
def store_pose(R_pad_solid, p_pad_solid, last_pose):
    """Write a pose into a row (POSE_FIELDS,)."""
    last_pose[12] = 1.0
    last_pose[9:12] = p_pad_solid
    for i in range(3):
        for j in range(3):
            last_pose[3 * i + j] = R_pad_solid[i, j]


@njit(cache=True, error_model="numpy")
def stable_limits(bed, dt, wrench, stiffness, mass):
    """Return the loss time, s, and slip speed, m/s, with which a light body stays stable.

    Friction that could reverse the body's motion within a step is made softer. A damper that could
    stop it within one step is weakened. Wrench (6,) and stiffness, N/m, are those of the last step.
    """
    held = sqrt(wrench[0] * wrench[0] + wrench[1] * wrench[1] + wrench[2] * wrench[2])
    slip = max(bed[SLIP_SPEED], _GRIP_MARGIN * dt * bed[FRICTION] * held / mass)
    rate = dt * stiffness / mass
    loss_time = bed[LOSS_TIME]
    if rate * loss_time > _MAX_DAMPING:
        loss_time = _MAX_DAMPING / rate
    return loss_time, slip

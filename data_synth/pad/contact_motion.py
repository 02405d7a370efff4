"""Where solids are in the pad's frame, how they move there, and what that allows: compiled."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

from .foam_column import FRICTION, LOSS_TIME, SLIP_SPEED

POSE_FIELDS = 13
"""Fields of a remembered pose: rotation row by row (9), place (3), 1.0 if it is remembered."""

_GRIP_MARGIN = 4.0
_MOST_DAMPING = 0.6


@njit(cache=True, error_model="numpy")
def into_pad(pad_place, pad_rotation, place, rotation, turned, moved):
    """Turn a pose in the world to the pad's frame: `turned` (3, 3), `moved` (3,), overwritten."""
    for i in range(3):
        total = 0.0
        for m in range(3):
            total += pad_rotation[3 * m + i] * (place[m] - pad_place[m])
        moved[i] = total
        for j in range(3):
            total = 0.0
            for m in range(3):
                total += pad_rotation[3 * m + i] * rotation[3 * m + j]
            turned[i, j] = total


@njit(cache=True, error_model="numpy")
def twist_since(turned, moved, before, dt, twist):
    """Velocity at the pad's origin and angular velocity from the pose before, in the pad's frame.

    A difference of poses holds for driven, placed and free bodies alike, and equals the velocity
    that a semi-implicit step has used.
    """
    twist[:] = 0.0
    if dt <= 0.0 or before[12] == 0.0:
        return
    change = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            total = 0.0
            for m in range(3):
                total += turned[i, m] * before[3 * j + m]
            change[i, j] = total
    for i in range(3):
        carried = 0.0
        for m in range(3):
            carried += change[i, m] * before[9 + m]
        twist[i] = (moved[i] - carried) / dt
    twist[3] = 0.5 * (change[2, 1] - change[1, 2]) / dt
    twist[4] = 0.5 * (change[0, 2] - change[2, 0]) / dt
    twist[5] = 0.5 * (change[1, 0] - change[0, 1]) / dt


@njit(cache=True, error_model="numpy")
def remember(turned, moved, before):
    """Write a pose into a row (POSE_FIELDS,)."""
    before[12] = 1.0
    before[9:12] = moved
    for i in range(3):
        for j in range(3):
            before[3 * i + j] = turned[i, j]


@njit(cache=True, error_model="numpy")
def calm_limits(bed, dt, wrench, stiffness, mass):
    """Give the loss time, s, and slip speed, m/s, that leave a light body calm.

    Friction that could turn its motion round within a step is made softer, and so is a damper
    that could stop it within one. Both are judged by the wrench (6,) and stiffness, N/m, of the
    step before.
    """
    held = sqrt(wrench[0] * wrench[0] + wrench[1] * wrench[1] + wrench[2] * wrench[2])
    slip = max(bed[SLIP_SPEED], _GRIP_MARGIN * dt * bed[FRICTION] * held / mass)
    quickness = dt * stiffness / mass
    loss_time = bed[LOSS_TIME]
    if quickness * loss_time > _MOST_DAMPING:
        loss_time = _MOST_DAMPING / quickness
    return loss_time, slip

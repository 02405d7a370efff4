"""Estimate of the true place of a contact under a sheared layer of foam (compiled).

A tangential force Ft on a layer of height h moves the measured centre of pressure by h Ft / Fn. The
arm's force sensor measures Ft, with noise, and the arm's joints measure how far the pad has moved
over the contact. The estimate moves with the pad, and follows the corrected centre slowly. Without
a force sensor, the centre at touch counts, because nothing has slid by then.
"""

from __future__ import annotations

import numpy as np
from numba import njit

PLACE_X, PLACE_Y, AGE, WEIGHT, TRAVEL, SIDE_X, SIDE_Y = range(7)
"""Indices of the state: the estimate at the time of the image (m), readings since touch, the weight
of the past readings, the length of the contact's path over the pad (m), and the tangential force on
the sensor in this cycle (N), NaN if unknown."""
PLACE_SIZE = 7
"""Length of the state."""
LOG_MOVE_X, LOG_MOVE_Y, LOG_SIDE_X, LOG_SIDE_Y = range(4)
"""Rows of the log of the last cycles: the contact's move over the pad (m), and the force (N)."""

FOLLOW_TIME = 1.0
"""Time constant with which the estimate follows the corrected centre at 1 N, s; longer for less
force. A longer time averages more of the force sensor's noise, a shorter one follows objects that
move."""
SHIFT_PER_TRAVEL = 60.0
"""Maximum shift of the centre by friction per path of the contact. Foam of shear modulus G under a
pressure p has G / p, which is 60 at 100 Pa. So a contact that has not moved needs no correction,
and the force sensor's noise does not enter."""
ROLL_ANGLE = 0.02
"""Rotation about x and y after which the estimate has followed, rad: a rolling pad moves the
contact in a way that depends on the object's shape."""
SIDE_NOISE = 0.1
"""Standard deviation of the force sensor's reading, N."""
OUTLIER, OUTLIER_SIGMAS = 1.5e-3, 4.0
"""Difference from the corrected centre at which the estimate follows twice as fast, m, and in
standard deviations of the force sensor's noise; the larger one counts."""
MIN_WEIGHT, MAX_WEIGHT = 1e-6, 1.0
"""Bounds of a reading's weight, the square of its normal force in N: the noise of the corrected
centre is inverse to the force."""
MAX_FRICTION = 1.0
"""Maximum expected ratio of tangential to normal force. Beyond it, the object itself has moved."""


@njit(cache=True)
def estimate_place(state, log, cycle, centre, force, motion, rule, place):
    """Estimate where the contact is now.

    Parameters
    ----------
    state
        (PLACE_SIZE,), updated in place.
    log
        (4, n), ring buffer of the last cycles, indexed by `cycle`; updated in place.
    cycle
        Number of this cycle.
    centre
        Measured centre of pressure, (3,), m, of an image that is `wait` cycles old.
    force
        Normal force, N, of that image, > 0.
    motion
        Twist of the sensor since the last cycle (6,), m/s and rad/s; NaN if unknown.
    rule
        Lever h (m), wait of the images (cycles, a whole number), and time since the last cycle (s).
    place
        (2,), filled with the estimate, m.
    """
    lever, wait, dt = rule
    size = log.shape[1]
    now, then = cycle % size, (cycle - int(wait)) % size
    log[LOG_SIDE_X, now], log[LOG_SIDE_Y, now] = state[SIDE_X], state[SIDE_Y]
    log[LOG_MOVE_X, now] = -(motion[0] - motion[5] * centre[1]) * dt
    log[LOG_MOVE_Y, now] = -(motion[1] + motion[5] * centre[0]) * dt
    state[AGE] += 1.0
    rolled = np.sqrt(motion[3] * motion[3] + motion[4] * motion[4]) * dt
    measured = np.isfinite(log[LOG_SIDE_X, then] + log[LOG_SIDE_Y, then])
    weight, outlier = 1.0, OUTLIER
    if measured:
        weight = min(max(force * force, MIN_WEIGHT), MAX_WEIGHT)
        outlier = max(OUTLIER, OUTLIER_SIGMAS * lever * SIDE_NOISE / force)
    forgotten = min(dt / FOLLOW_TIME * np.sqrt(weight), 1.0)
    state[WEIGHT] = (1.0 - forgotten) * state[WEIGHT] + weight
    state[TRAVEL] += np.hypot(log[LOG_MOVE_X, then], log[LOG_MOVE_Y, then])
    reach = min(lever * MAX_FRICTION, SHIFT_PER_TRAVEL * state[TRAVEL])
    for axis in range(2):
        state[PLACE_X + axis] += log[LOG_MOVE_X + axis, then]
        known = state[PLACE_X + axis]
        target = centre[axis]
        if measured:
            shift = lever * log[LOG_SIDE_X + axis, then] / force
            target -= min(max(shift, -reach), reach)
        elif state[AGE] > 1.0:
            target = min(max(known, target - reach), target + reach)
        error = target - known
        share = weight / state[WEIGHT] * (1.0 + (error / outlier) ** 2) + rolled / ROLL_ANGLE
        share = min(share, 1.0)
        state[PLACE_X + axis] = known + share * error
        place[axis] = state[PLACE_X + axis]
        # The image is old: the pad has moved since.
        for back in range(int(wait)):
            place[axis] += log[LOG_MOVE_X + axis, (cycle - back) % size]


@njit(cache=True)
def lose_place(state):
    """Forget the contact."""
    state[:SIDE_X] = 0.0

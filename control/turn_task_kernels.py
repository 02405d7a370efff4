"""The tasks of :mod:`turn_aims`, compiled; see :mod:`point_task_kernels` for how they are called.

``axes`` (9,) are the frame's, ``jacobian`` (6, n) is that of its origin; work arrays are (3, n).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .turn_aims import LARGEST_STRETCH, NEAREST_TARGET, NO_ANGLE


@njit(cache=True)
def orientation_task(goal, axes, jacobian, error, rows):
    """`Orientation`: 3 rows; ``goal`` (9,)."""
    x, y, z = _rotation_vector(goal, axes)
    error[0], error[1], error[2] = x, y, z
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-3:
        factor = 1.0 / 12.0
    else:
        factor = (1.0 - angle / 2.0 / math.tan(angle / 2.0)) / angle**2
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        d, e, f = y * c - z * b, z * a - x * c, x * b - y * a
        rows[0, column] = a + 0.5 * d + factor * (y * f - z * e)
        rows[1, column] = b + 0.5 * e + factor * (z * d - x * f)
        rows[2, column] = c + 0.5 * f + factor * (x * e - y * d)
    return 3


@njit(cache=True)
def pose_task(fields, gain, speed, point, linear, axes, jacobian, error, rows):
    """`Pose`: 6 rows; ``fields``: rotation (9,), position (3,), speed of turning.

    Returns the rows and the speed of all six coordinates at which neither speed is passed.
    """
    away = 0.0
    for axis in range(3):
        error[axis] = fields[9 + axis] - point[axis]
        away += error[axis] * error[axis]
        rows[axis] = linear[axis]
    orientation_task(fields, axes, jacobian, error[3:], rows[3:])
    turn = error[3] * error[3] + error[4] * error[4] + error[5] * error[5]
    excess = gain * max(math.sqrt(away) / speed, math.sqrt(turn) / fields[12])
    if excess > 1.0:
        return 6, gain * math.sqrt(away + turn) / excess
    return 6, np.inf


@njit(cache=True)
def axis_alignment_task(fields, axes, jacobian, motion, error, rows):
    """`AxisAlignment`: 2 rows; ``fields``: across (2, 3), goal (3,), axis (3,)."""
    x = axes[0] * fields[9] + axes[1] * fields[10] + axes[2] * fields[11]
    y = axes[3] * fields[9] + axes[4] * fields[10] + axes[5] * fields[11]
    z = axes[6] * fields[9] + axes[7] * fields[10] + axes[8] * fields[11]
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        motion[0, column] = b * z - c * y
        motion[1, column] = c * x - a * z
        motion[2, column] = a * y - b * x
    _direction_rows((x, y, z), motion, fields[6:9], fields[:6], error, rows)
    error[0], error[1] = -error[0], -error[1]
    return 2


@njit(cache=True)
def look_at_task(fields, point, linear, axes, jacobian, motion, value, error, rows):
    """`LookAt`: 2 rows on the axis, or 1 on the angle, whose bound the caller keeps, or none.

    ``fields``: across (2, 3), axis (3,), target (3,), half angle.
    """
    x, y, z = fields[9] - point[0], fields[10] - point[1], fields[11] - point[2]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance < NEAREST_TARGET:
        return 0
    x, y, z = x / distance, y / distance, z / distance
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        u, v, w = linear[0, column], linear[1, column], linear[2, column]
        along = x * u + y * v + z * w
        u = (x * along - u) / distance + y * c - z * b
        v = (y * along - v) / distance + z * a - x * c
        w = (z * along - w) / distance + x * b - y * a
        for axis in range(3):
            motion[axis, column] = axes[axis] * u + axes[3 + axis] * v + axes[6 + axis] * w
    look = (
        axes[0] * x + axes[3] * y + axes[6] * z,
        axes[1] * x + axes[4] * y + axes[7] * z,
        axes[2] * x + axes[5] * y + axes[8] * z,
    )
    if fields[12] == 0.0:
        _direction_rows(look, motion, fields[6:9], fields[:6], error, rows)
        error[0], error[1] = -error[0], -error[1]
        return 2
    _, _, angle, _ = _polar(look, motion, fields[6:9], fields[:6], rows)
    value[0] = angle
    return 1


@njit(cache=True)
def _direction_rows(direction, motion, pole, basis, value, rows):
    """Fill value (2,) and rows (2, n); see `turn_aims.direction_rows`."""
    inward, around, angle, sine = _polar(direction, motion, pole, basis, rows)
    value[0], value[1] = angle * inward, angle * around
    # Below, rows[0] is the angle's row and rows[1] is yet to come.
    stretch = min(angle / sine, LARGEST_STRETCH) if sine > 0.0 else LARGEST_STRETCH
    for column in range(motion.shape[1]):
        first, second = _across(motion, basis, column)
        if angle < NO_ANGLE:
            rows[0, column], rows[1, column] = first, second
            continue
        turning = stretch * (inward * second - around * first)
        radial = rows[0, column]
        rows[0, column] = inward * radial - around * turning
        rows[1, column] = around * radial + inward * turning


@njit(cache=True)
def _polar(direction, motion, pole, basis, rows):
    """Unit vector from the pole in the basis, angle, sine; rows[0] becomes the angle's row."""
    first = basis[0] * direction[0] + basis[1] * direction[1] + basis[2] * direction[2]
    second = basis[3] * direction[0] + basis[4] * direction[1] + basis[5] * direction[2]
    cosine = pole[0] * direction[0] + pole[1] * direction[1] + pole[2] * direction[2]
    sine = math.sqrt(first * first + second * second)
    if sine < NO_ANGLE:
        # Neither way is shorter: take the one that moves better.
        one = other = 0.0
        for column in range(motion.shape[1]):
            a, b = _across(motion, basis, column)
            one += a * a
            other += b * b
        first, second = (0.0, 1.0) if other > one else (1.0, 0.0)
    else:
        first, second = first / sine, second / sine
    for column in range(motion.shape[1]):
        a, b = _across(motion, basis, column)
        along = pole[0] * motion[0, column] + pole[1] * motion[1, column]
        along += pole[2] * motion[2, column]
        rows[0, column] = cosine * (first * a + second * b) - sine * along
    return first, second, math.atan2(sine, cosine), sine


@njit(cache=True)
def _across(motion, basis, column):
    x, y, z = motion[0, column], motion[1, column], motion[2, column]
    return (
        basis[0] * x + basis[1] * y + basis[2] * z,
        basis[3] * x + basis[4] * y + basis[5] * z,
    )


@njit(cache=True)
def _rotation_vector(goal, axes):
    """Rotation vector of goal times the axes' transpose (9,) (9,), see `turn_aims`."""
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
    # At half a turn rounding must not choose the way round.
    if w < -NO_ANGLE * sine:
        w, x, y, z = -w, -x, -y, -z
    stretch = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 0.0
    return x * stretch, y * stretch, z * stretch

"""The angles between a unit direction and a pole, and their derivatives."""

from __future__ import annotations

import math

from numba import njit

MIN_ANGLE = 1e-9
"""Minimum angle that has a direction, rad. The direction of a smaller one is rounding error."""
MAX_STRETCH = 100.0
"""Upper limit of angle / sine, the factor of rotation about the pole. The limit acts within 2° of
the opposite direction. Without it, this row would dominate all others there."""


@njit(cache=True)
def direction_rows(direction, motion, pole, basis, value, rows):
    """Fill the two angles of a unit direction from a pole, and their derivatives (2, n).

    Parameters
    ----------
    direction, pole
        Unit vectors, three numbers each.
    motion
        Derivative of the direction (3, n).
    basis
        Two unit vectors perpendicular to the pole and to each other (6,).
    value, rows
        To be filled.
    """
    u, v, angle, sine = polar_row(direction, motion, pole, basis, rows)
    value[0], value[1] = angle * u, angle * v
    # At the start of the loop, rows[0] holds the derivative of the angle.
    stretch = min(angle / sine, MAX_STRETCH) if sine > 0.0 else MAX_STRETCH
    for column in range(motion.shape[1]):
        first, second = _coordinates(motion, basis, column)
        if angle < MIN_ANGLE:
            rows[0, column], rows[1, column] = first, second
            continue
        turning = stretch * (u * second - v * first)
        radial = rows[0, column]
        rows[0, column] = u * radial - v * turning
        rows[1, column] = v * radial + u * turning


@njit(cache=True)
def polar_row(direction, motion, pole, basis, rows):
    """Return the unit vector from the pole in the basis, the angle and its sine; fill rows[0].

    rows[0] becomes the derivative of the angle.
    """
    first = basis[0] * direction[0] + basis[1] * direction[1] + basis[2] * direction[2]
    second = basis[3] * direction[0] + basis[4] * direction[1] + basis[5] * direction[2]
    cosine = pole[0] * direction[0] + pole[1] * direction[1] + pole[2] * direction[2]
    sine = math.sqrt(first * first + second * second)
    if sine < MIN_ANGLE:
        # Both rotations have the same angle: use the direction in which the joints move better.
        one = other = 0.0
        for column in range(motion.shape[1]):
            a, b = _coordinates(motion, basis, column)
            one += a * a
            other += b * b
        first, second = (0.0, 1.0) if other > one else (1.0, 0.0)
    else:
        first, second = first / sine, second / sine
    for column in range(motion.shape[1]):
        a, b = _coordinates(motion, basis, column)
        along = pole[0] * motion[0, column] + pole[1] * motion[1, column]
        along += pole[2] * motion[2, column]
        rows[0, column] = cosine * (first * a + second * b) - sine * along
    return first, second, math.atan2(sine, cosine), sine


@njit(cache=True)
def _coordinates(motion, basis, column):
    x, y, z = motion[0, column], motion[1, column], motion[2, column]
    return (
        basis[0] * x + basis[1] * y + basis[2] * z,
        basis[3] * x + basis[4] * y + basis[5] * z,
    )

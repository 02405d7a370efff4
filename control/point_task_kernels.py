"""The tasks of :mod:`point_aims`, compiled: errors and rows from a packed task's fields.

Each kernel fills ``error`` (m,) and ``rows`` (m, n) and returns m; those of one row put the value
into ``value`` (1,).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .point_aims import NO_DISTANCE


@njit(cache=True)
def moved_point(offset, position, axes, jacobian, point, linear):
    """Fill position (3,) and linear Jacobian (3, n) of a point that moves with the frame.

    ``position`` (3,), ``axes`` (9,) and ``jacobian`` (6, n) are those of the frame, ``offset`` (3,)
    is the point in it.
    """
    x = axes[0] * offset[0] + axes[1] * offset[1] + axes[2] * offset[2]
    y = axes[3] * offset[0] + axes[4] * offset[1] + axes[5] * offset[2]
    z = axes[6] * offset[0] + axes[7] * offset[1] + axes[8] * offset[2]
    point[0], point[1], point[2] = position[0] + x, position[1] + y, position[2] + z
    for column in range(jacobian.shape[1]):
        a, b, c = jacobian[3, column], jacobian[4, column], jacobian[5, column]
        linear[0, column] = jacobian[0, column] + b * z - c * y
        linear[1, column] = jacobian[1, column] + c * x - a * z
        linear[2, column] = jacobian[2, column] + a * y - b * x


@njit(cache=True)
def position_task(goal, point, linear, error, rows):
    """`Position`: 3 rows; ``goal`` (3,)."""
    for axis in range(3):
        error[axis] = goal[axis] - point[axis]
        rows[axis] = linear[axis]
    return 3


@njit(cache=True)
def distance_to_point_task(fields, point, linear, value, error, rows):
    """`DistanceToPoint`: 1 row; ``fields``: centre (3,), distance."""
    offset = (point[0] - fields[0], point[1] - fields[1], point[2] - fields[2])
    value[0] = _length_row(offset, linear, rows[0])
    error[0] = fields[3] - value[0]
    return 1


@njit(cache=True)
def distance_to_axis_task(fields, point, linear, value, error, rows):
    """`DistanceToAxis`: 1 row, 2 with distance 0; ``fields``: point, across (2, 3), distance."""
    x, y, z = point[0] - fields[0], point[1] - fields[1], point[2] - fields[2]
    first = fields[3] * x + fields[4] * y + fields[5] * z
    second = fields[6] * x + fields[7] * y + fields[8] * z
    across = np.empty((2, linear.shape[1]))
    for row in range(2):
        for column in range(linear.shape[1]):
            total = 0.0
            for axis in range(3):
                total += fields[3 + 3 * row + axis] * linear[axis, column]
            across[row, column] = total
    distance = fields[9]
    if distance == 0.0:
        error[0], error[1] = -first, -second
        rows[0], rows[1] = across[0], across[1]
        return 2
    value[0] = _length_row((first, second), across, rows[0])
    error[0] = distance - value[0]
    return 1


@njit(cache=True)
def point_on_plane_task(fields, point, linear, value, error, rows):
    """`PointOnPlane`: 1 row; ``fields``: normal (3,), offset."""
    value[0] = fields[0] * point[0] + fields[1] * point[1] + fields[2] * point[2]
    error[0] = fields[3] - value[0]
    for column in range(linear.shape[1]):
        rows[0, column] = (
            fields[0] * linear[0, column]
            + fields[1] * linear[1, column]
            + fields[2] * linear[2, column]
        )
    return 1


@njit(cache=True)
def _length_row(offset, coordinates, row):
    """Length of an offset (k,) and its derivative (n,), see `point_aims.length_row`."""
    square = 0.0
    for axis in range(len(offset)):
        square += offset[axis] * offset[axis]
    length = math.sqrt(square)
    if length < NO_DISTANCE:
        best, largest = 0, -1.0
        for axis in range(len(offset)):
            size = 0.0
            for column in range(len(row)):
                size += coordinates[axis, column] * coordinates[axis, column]
            if size > largest:
                best, largest = axis, size
        row[:] = coordinates[best]
        return length
    for column in range(len(row)):
        total = 0.0
        for axis in range(len(offset)):
            total += offset[axis] * coordinates[axis, column]
        row[column] = total / length
    return length

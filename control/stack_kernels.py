"""The strict stack of :mod:`stack`, compiled.

Instead of a basis of what is free it keeps the directions that are used: a level's rows, cleared of
those, have the same singular values and right vectors, and no basis has to be completed. Singular
vectors come from rotating pairs of rows until all are orthogonal (Hestenes 1958), which for a
handful of rows is faster than LAPACK's call, and exact for small ones.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .stack import LOST, ROUNDING

ORTHOGONAL = 4e-15
"""Cosine between two rows below which they count as orthogonal: their rounding."""
SWEEPS = 15
"""Rotations of all pairs of rows; they are orthogonal after four to six."""
NO_ROW = 1e-6 * LOST
"""Rows shorter than this are rounding, and not worth a rotation."""


@njit(cache=True)
def solve_levels(sizes, sides, rates, rows, free_motion, speed, near_singular, damping, velocity):
    """Fill the joint velocities (n,) of a stack; see `stack.solve_stack` with ``mode="strict"``.

    Parameters
    ----------
    sizes, sides
        (K,): number of rows and side of each task.
    rates, rows
        (K, M), (K, M, n): commanded rates and rows, of which the first `sizes` count.
    free_motion, speed
        (n,) each.
    near_singular, damping
        As in :class:`ControlOptions`.
    velocity
        (n,), to be filled.
    """
    tasks, most, joints = rows.shape
    dropped = np.empty(tasks, np.bool_)
    for task in range(tasks):
        dropped[task] = sides[task] != 0 and sizes[task] == 1
    block = np.empty((most + joints + 1, joints + 1))
    level, used = block[:most], block[most : most + joints, :joints]
    step = block[most + joints, :joints]
    while True:
        velocity[:] = 0.0
        count = 0
        for task in range(tasks):
            m = sizes[task]
            if dropped[task] or m == 0 or count == joints:
                continue
            _level(rates[task], rows[task], m, velocity, used, count, level)
            orthogonalise(level[:m], joints)
            count = _add_directions(level[:m], used, count, near_singular, damping, step)
            _go(velocity, step, speed)
        if count < joints:
            for joint in range(joints):
                step[joint] = free_motion[joint]
            _clear(step, used, count)
            _go(velocity, step, speed)
        broken = -1
        for task in range(tasks):
            if dropped[task] and broken < 0:
                left = _dot(rows[task, 0], velocity, joints) - rates[task, 0]
                if sides[task] * left < -LOST:
                    broken = task
        if broken < 0:
            return
        # One at a time, the highest first: with it held, the next may move the allowed way.
        dropped[broken] = False


@njit(cache=True)
def orthogonalise(rows, columns):
    """Rotate rows (m, columns and more) in pairs until they are orthogonal in their columns.

    Their lengths are then the singular values, their directions the right vectors; what is beyond
    the columns is rotated along.
    """
    m, width = rows.shape
    for _ in range(SWEEPS):
        turned = False
        for i in range(m - 1):
            for j in range(i + 1, m):
                a = _dot(rows[i], rows[i], columns)
                b = _dot(rows[j], rows[j], columns)
                c = _dot(rows[i], rows[j], columns)
                if c * c <= ORTHOGONAL**2 * a * b or min(a, b) < NO_ROW**2:
                    continue
                turned = True
                ratio = (b - a) / (2.0 * c)
                tangent = 1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
                if ratio < 0.0:
                    tangent = -tangent
                cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
                sine = cosine * tangent
                for k in range(width):
                    x, y = rows[i, k], rows[j, k]
                    rows[i, k] = cosine * x - sine * y
                    rows[j, k] = sine * x + cosine * y
        if not turned:
            return


@njit(cache=True)
def _level(rate, rows, m, velocity, used, count, level):
    """Fill a level's rows, cleared of what is used, and after them what is left of their rate."""
    joints = len(velocity)
    for row in range(m):
        for joint in range(joints):
            level[row, joint] = rows[row, joint]
        level[row, joints] = rate[row] - _dot(rows[row], velocity, joints)
        _clear(level[row, :joints], used, count)


@njit(cache=True)
def _add_directions(level, used, count, near_singular, damping, step):
    """Add a level's directions to those used, and fill its step; the number used then."""
    joints = len(step)
    step[:] = 0.0
    for row in range(len(level)):
        size = math.sqrt(_dot(level[row], level[row], joints))
        if size <= LOST or count == joints:
            continue
        direction = used[count]
        for joint in range(joints):
            direction[joint] = level[row, joint] / size
        # Short rows carry more of the rounding: without this the null space would leak.
        _clear(direction, used, count)
        length = math.sqrt(_dot(direction, direction, joints))
        share = max(1.0 - (size / near_singular) ** 2, 0.0)
        gain = size / (size * size + damping * damping * share)
        for joint in range(joints):
            direction[joint] /= length
            step[joint] += gain * level[row, joints] * direction[joint]
        count += 1
    return count


@njit(cache=True)
def _clear(vector, used, count):
    """Take out of a vector (n,) what lies along directions; twice, for the first one's rounding."""
    if count == 0:
        return
    joints = len(vector)
    for _ in range(2):
        for row in range(count):
            along = _dot(used[row], vector, joints)
            for joint in range(joints):
                vector[joint] -= along * used[row, joint]


@njit(cache=True)
def _go(velocity, step, speed):
    """Add as much of a step as joint speeds allow; see `stack._allowed_share`."""
    share = 1.0
    for joint in range(len(step)):
        size = abs(step[joint])
        toward = velocity[joint] if step[joint] > 0.0 else -velocity[joint]
        room = max(speed[joint] - toward, 0.0)
        if size > room + ROUNDING:
            share = min(share, room / size)
    for joint in range(len(step)):
        velocity[joint] += share * step[joint]


@njit(cache=True)
def _dot(a, b, size):
    total = 0.0
    for k in range(size):
        total += a[k] * b[k]
    return total

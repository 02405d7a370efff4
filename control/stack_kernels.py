"""The compiled solution of a stack of tasks by priority.

The kernel does not keep a basis of the null space. It keeps the joint directions that the upper
tasks use, and removes them from the rows of the next task. The singular values and right vectors
are the same. The singular value decomposition rotates pairs of rows until all rows are orthogonal
(Hestenes 1958). For a few rows this is faster than a call of LAPACK, and it is exact for small
singular values.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

LOST = 1e-7
"""Minimum singular value with a direction. The vector of a smaller one is rounding error."""
ROUNDING = 1e-12
"""Maximum excess over a joint speed limit, rad/s. If a task above uses the full speed of a joint,
rounding must not stop the tasks below."""
NEAR_SINGULAR = 0.05
"""Singular values below this are damped; smaller ones are damped more. A larger threshold keeps
joints slower near singular postures, and makes the task less exact there."""
DAMPING = 0.05
"""Damping of a direction whose singular value is zero."""
ORTHOGONAL = 4e-15
"""Maximum cosine between two orthogonal rows: their rounding error."""
SWEEPS = 15
"""Maximum number of rotations of all pairs of rows. Four to six make them orthogonal."""
NO_ROW = 1e-6 * LOST
"""Minimum length of a row that is rotated. Shorter rows are rounding error."""


class Levels(NamedTuple):
    """K tasks by priority, for kernels. The first ``sizes[k]`` of the M rows of task k are used."""

    sizes: NDArray[np.int64]
    """(K,) number of rows."""
    sides: NDArray[np.int64]
    """(K,), see :class:`TaskRows`."""
    rates: NDArray[np.float64]
    """(K, M) commanded rates."""
    rows: NDArray[np.float64]
    """(K, M, n) Jacobians."""


@njit(cache=True)
def solve_levels(levels, free_motion, speed, velocity, scale, dropped):
    """Compute the joint velocities of a stack, see `stack.solve_stack`.

    Parameters
    ----------
    levels
        A :class:`Levels`.
    free_motion, speed
        (n,) each.
    velocity
        (n,), to be filled.
    scale, dropped
        (K,) each, to be filled as in :class:`StackSolution`.
    """
    sizes, sides, rates, rows = levels
    tasks, max_rows, joints = rows.shape
    for task in range(tasks):
        dropped[task] = sides[task] != 0 and sizes[task] == 1
    block = np.empty((max_rows + joints + 1, joints + 1))
    level, used = block[:max_rows], block[max_rows : max_rows + joints, :joints]
    step = block[max_rows + joints, :joints]
    while True:
        velocity[:] = 0.0
        count = 0
        for task in range(tasks):
            m = sizes[task]
            scale[task] = 1.0
            if dropped[task] or m == 0:
                continue
            if count == joints:
                scale[task] = 0.0
                continue
            _reduced_rows(rates[task], rows[task], m, velocity, used, count, level)
            orthogonalise(level[:m], joints)
            count = _add_directions(level[:m], used, count, step)
            scale[task] = _add_step(velocity, step, speed)
        if count < joints:
            for joint in range(joints):
                step[joint] = free_motion[joint]
            _remove_directions(step, used, count)
            _add_step(velocity, step, speed)
        broken = -1
        for task in range(tasks):
            if dropped[task] and broken < 0:
                left = _dot(rows[task, 0], velocity, joints) - rates[task, 0]
                if sides[task] * left < -LOST:
                    broken = task
        if broken < 0:
            return
        # Add one dropped task at a time, the highest first. With it, the next may be satisfied.
        dropped[broken] = False


@njit(cache=True)
def orthogonalise(rows, columns):
    """Rotate rows in pairs until their first ``columns`` entries are orthogonal.

    The lengths of the rows are then the singular values, and their directions the right vectors.
    Entries beyond the columns are rotated too.
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
def _reduced_rows(rate, rows, m, velocity, used, count, level):
    """Fill a task's rows without the directions in use; the last column is the missing rate."""
    joints = len(velocity)
    for row in range(m):
        for joint in range(joints):
            level[row, joint] = rows[row, joint]
        level[row, joints] = rate[row] - _dot(rows[row], velocity, joints)
        _remove_directions(level[row, :joints], used, count)


@njit(cache=True)
def _add_directions(level, used, count, step):
    """Add a task's directions to those in use and fill its step; return the number in use."""
    joints = len(step)
    step[:] = 0.0
    for row in range(len(level)):
        size = math.sqrt(_dot(level[row], level[row], joints))
        if size <= LOST or count == joints:
            continue
        direction = used[count]
        for joint in range(joints):
            direction[joint] = level[row, joint] / size
        # Short rows have larger relative rounding errors, which would disturb upper tasks.
        _remove_directions(direction, used, count)
        length = math.sqrt(_dot(direction, direction, joints))
        weight = max(1.0 - (size / NEAR_SINGULAR) ** 2, 0.0)
        gain = size / (size * size + DAMPING * DAMPING * weight)
        for joint in range(joints):
            direction[joint] /= length
            step[joint] += gain * level[row, joints] * direction[joint]
        count += 1
    return count


@njit(cache=True)
def _remove_directions(vector, used, count):
    """Remove the components of a vector (n,) along the directions in use, twice due to rounding."""
    if count == 0:
        return
    joints = len(vector)
    for _ in range(2):
        for row in range(count):
            along = _dot(used[row], vector, joints)
            for joint in range(joints):
                vector[joint] -= along * used[row, joint]


@njit(cache=True)
def _add_step(velocity, step, speed):
    """Add the fraction of a step that the joint speed limits allow, and return this fraction."""
    fraction = 1.0
    for joint in range(len(step)):
        size = abs(step[joint])
        toward = velocity[joint] if step[joint] > 0.0 else -velocity[joint]
        room = max(speed[joint] - toward, 0.0)
        if size > room + ROUNDING:
            fraction = min(fraction, room / size)
    for joint in range(len(step)):
        velocity[joint] += fraction * step[joint]
    return fraction


@njit(cache=True)
def _dot(a, b, size):
    total = 0.0
    for k in range(size):
        total += a[k] * b[k]
    return total

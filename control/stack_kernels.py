"""The compiled solution of a stack of tasks by priority.

Instead of a basis of the free directions, the kernel keeps the directions that are in use. The rows
of a level, cleared of those, have the same singular values and right vectors, and no basis has to
be completed. Singular vectors come from rotations of pairs of rows until all are orthogonal
(Hestenes 1958). For a handful of rows this is faster than a call of LAPACK, and it is exact for
small singular values.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

LOST = 1e-7
"""Singular values below this have no direction: rounding makes their vectors arbitrary."""
ROUNDING = 1e-12
"""Excess over a joint's speed limit that is allowed, rad/s. Where a level above has used up a
joint, the rounding of the levels below must not stop them."""
NEAR_SINGULAR = 0.05
"""Singular values below this are damped, more the smaller they are: larger keeps joints slower near
singular postures, and the task less exact there."""
DAMPING = 0.05
"""Damping of a direction whose singular value is zero."""
ORTHOGONAL = 4e-15
"""Cosine between two rows below which they count as orthogonal: their rounding."""
SWEEPS = 15
"""Rotations of all pairs of rows; they are orthogonal after four to six."""
NO_ROW = 1e-6 * LOST
"""Rows shorter than this are rounding, and not worth a rotation."""


class Levels(NamedTuple):
    """K tasks by priority, for kernels; of the M rows of task k the first ``sizes[k]`` count."""

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
    """Fill the joint velocities of a stack, see `stack.solve_stack`.

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
    tasks, most, joints = rows.shape
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
            scale[task] = 1.0
            if dropped[task] or m == 0:
                continue
            if count == joints:
                scale[task] = 0.0
                continue
            _level(rates[task], rows[task], m, velocity, used, count, level)
            orthogonalise(level[:m], joints)
            count = _add_directions(level[:m], used, count, step)
            scale[task] = _go(velocity, step, speed)
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

    Their lengths are then the singular values, their directions the right vectors. Entries beyond
    the columns are rotated along.
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
    """Fill a level's rows, cleared of the directions in use, and after them the rates left."""
    joints = len(velocity)
    for row in range(m):
        for joint in range(joints):
            level[row, joint] = rows[row, joint]
        level[row, joints] = rate[row] - _dot(rows[row], velocity, joints)
        _clear(level[row, :joints], used, count)


@njit(cache=True)
def _add_directions(level, used, count, step):
    """Add a level's directions to those in use and fill its step; return how many are in use."""
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
        share = max(1.0 - (size / NEAR_SINGULAR) ** 2, 0.0)
        gain = size / (size * size + DAMPING * DAMPING * share)
        for joint in range(joints):
            direction[joint] /= length
            step[joint] += gain * level[row, joints] * direction[joint]
        count += 1
    return count


@njit(cache=True)
def _clear(vector, used, count):
    """Remove from a vector (n,) its parts along directions, twice because of rounding."""
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
    """Add as much of a step as joint speeds allow, and return the share added."""
    share = 1.0
    for joint in range(len(step)):
        size = abs(step[joint])
        toward = velocity[joint] if step[joint] > 0.0 else -velocity[joint]
        room = max(speed[joint] - toward, 0.0)
        if size > room + ROUNDING:
            share = min(share, room / size)
    for joint in range(len(step)):
        velocity[joint] += share * step[joint]
    return share


@njit(cache=True)
def _dot(a, b, size):
    total = 0.0
    for k in range(size):
        total += a[k] * b[k]
    return total

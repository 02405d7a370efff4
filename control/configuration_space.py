"""The configuration space of a robot among obstacles, for compiled kernels: clearance and costs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .kinematics_kernels import set_posture
from .proximity_kernels import NEAR_COLUMNS, measure_near, update_held_geoms
from .proximity_tables import World, nearer

CHECK_STEP = 0.02
"""Distance between two checked configurations of an edge, m: the sum of each joint's motion times
its lever."""
AROUND_ENDS = 0.25
"""Joint distance from start and goals within which the smaller clearance is enough, rad."""


class Space(NamedTuple):
    """A robot among obstacles. The arrays are views of MuJoCo's buffers or `ProximityTables`."""

    world: World
    qpos: NDArray[np.float64]
    body_positions: NDArray[np.float64]
    body_axes: NDArray[np.float64]
    joints: NDArray[np.int64]
    pairs: NDArray[np.int64]
    held: NDArray[np.float64]
    origin: NDArray[np.float64]
    """Origin (3,) of the controlled frame."""


class Motion(NamedTuple):
    """The constraints and the cost of a path."""

    clearance: float
    """Minimum distance of all pairs, m."""
    end_clearance: float
    """Minimum distance near the ends of the path, m."""
    ends: NDArray[np.float64]
    """Start and goals (1 + G, n)."""
    levers: NDArray[np.float64]
    """(n,): maximum motion of the robot's parts per joint motion, m/rad."""
    joint_speed: NDArray[np.float64]
    """(n,), rad/s."""
    frame_speed: float
    """m/s."""


@njit(cache=True, nogil=True)
def clearance_at(q, space, cut_off):
    """Return the minimum distance of all pairs at q (n,), at most the cut-off, m."""
    world = space.world
    set_posture(world.model, world.data, q, space.qpos, space.joints[:, 0])
    update_held_geoms(
        space.held, space.body_positions, space.body_axes, world.positions, world.matrices
    )
    near = np.empty((len(space.pairs), NEAR_COLUMNS))
    needed = np.full(len(space.pairs), cut_off)
    count = measure_near(near, nearer(world, cut_off), space.pairs, needed)
    least = cut_off
    for row in range(count):
        least = min(least, near[row, 1])
    return least


@njit(cache=True, nogil=True)
def edge_cost(start, end, space, motion):
    """Return the time of the straight motion between two configurations (n,), s.

    Return infinity if a configuration on it is too close to an obstacle. The start is not checked.
    """
    n = len(start)
    length = 0.0
    for joint in range(n):
        length += motion.levers[joint] * abs(end[joint] - start[joint])
    count = max(math.ceil(length / CHECK_STEP), 1)
    q, last = start.copy(), np.empty(3)
    set_posture(space.world.model, space.world.data, q, space.qpos, space.joints[:, 0])
    last[:] = space.origin
    by_joint = 0.0
    for joint in range(n):
        turn = abs(end[joint] - start[joint]) / count
        by_joint = max(by_joint, turn / motion.joint_speed[joint])
    cost = 0.0
    for k in range(1, count + 1):
        for joint in range(n):
            q[joint] = start[joint] + (end[joint] - start[joint]) * k / count
        wanted = motion.clearance
        for row in range(len(motion.ends)):
            farthest = 0.0
            for joint in range(n):
                farthest = max(farthest, abs(q[joint] - motion.ends[row, joint]))
            if farthest < AROUND_ENDS:
                wanted = motion.end_clearance
        if clearance_at(q, space, wanted) < wanted:
            return np.inf
        square = 0.0
        for axis in range(3):
            square += (space.origin[axis] - last[axis]) ** 2
            last[axis] = space.origin[axis]
        cost += max(by_joint, math.sqrt(square) / motion.frame_speed)
    return cost

"""The distances on the way to standstill, for the pairs that can bound a command there."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .braking_kernels import ACCELERATION, brake_cycles, braked_posture
from .distance_bounds import APPROACHING, Chain, bounds_at_stop, distance_rows, limit_approach
from .kinematics_kernels import set_posture
from .packed_options import DAMPER, DT, INFLUENCE, MARGIN
from .proximity_kernels import NEAR_COLUMNS, measure_near, update_held_geoms
from .proximity_tables import BOUND, FULL_SCALE, World
from .safety_kernels import SLACK

MOVING = 1e-9
"""Minimum distance between the present posture and standstill, rad or m. Below it both count as
one posture."""
WAY_STEP = 0.1
"""Maximum joint step between two measured postures on the way to standstill, rad or m. Arms that
brake within one step are measured at standstill only."""


class Arm(NamedTuple):
    """A robot among obstacles: views of MuJoCo's buffers and fields of `ProximityTables`."""

    world: World
    chain: Chain
    qpos: NDArray[np.float64]
    held: NDArray[np.float64]
    body_positions: NDArray[np.float64]
    body_axes: NDArray[np.float64]


@njit(cache=True)
def add_way_bounds(arm, near, case, needed, count, bounds, used):
    """Add the bounds by the distances on the way to standstill; return the number of rows in use.

    Parameters
    ----------
    arm
        An :class:`Arm`. The poses in the data must be those of the present posture.
    near
        Rows of `measure_near` in this posture.
    case
        A :class:`BrakingCase`.
    needed
        (pairs,), see `needed_distances`.
    count
        Number of postures, see `way_postures`.
    bounds, used
        :class:`DistanceBounds`, and the number of its rows in use.
    """
    world, chain, n = arm.world, arm.chain, len(case.q)
    every = len(chain.pairs)
    chosen, pairs = np.empty(every, np.int64), np.empty((every, 3), np.int64)
    # A pair that was not measured in this posture is beyond the cut-off, or not needed.
    distances = np.full(every, world.cut_off)
    for row in range(len(near)):
        distances[int(near[row, 0])] = near[row, 1]
    size = 0
    for pair in range(every):
        if distances[pair] < needed[pair]:
            chosen[size] = pair
            pairs[size] = chain.pairs[pair]
            size += 1
    if size == 0:
        return used
    chosen, pairs = chosen[:size], pairs[:size]
    block, rows = np.empty((size, NEAR_COLUMNS)), np.empty((size, n))
    drifts, posture, dt = np.empty(size), np.empty(n), case.options[DT]
    to_cut_off = np.full(size, world.cut_off)
    cycles = brake_cycles(case.braking.command, case.limits, dt)
    for step in range(1, count + 1):
        after, until = cycles * step // count, np.inf
        if step < count:
            until = dt * after
            braked_posture(case.q, case.motion, case.limits, dt, after, posture)
        else:
            posture[:] = case.braking.stop
        set_posture(world.model, world.data, posture, arm.qpos, chain.joints[:, 0])
        update_held_geoms(
            arm.held, arm.body_positions, arm.body_axes, world.positions, world.matrices
        )
        there = block[: measure_near(block, world, pairs, to_cut_off)]
        for row in range(len(there)):
            there[row, 0] = chosen[int(there[row, 0])]
        distance_rows(there, chain, rows, drifts)
        limit_approach(there[:, 1], rows, drifts, case.limits, case.options)
        used = bounds_at_stop(there, rows, drifts, until, case, bounds, used)
    return used


@njit(cache=True)
def way_postures(q, stop):
    """Return the number of postures to measure on the way to standstill, the standstill included.

    0 means that the arm stands still.
    """
    farthest = 0.0
    for joint in range(len(q)):
        farthest = max(farthest, abs(stop[joint] - q[joint]))
    return math.ceil(farthest / WAY_STEP) if farthest > MOVING else 0


@njit(cache=True)
def needed_distances(arm, case, needed):
    """Fill the distance of each pair beyond which it cannot matter in this cycle (2, pairs), m.

    Row 0 is for the way to standstill, row 1 for the present posture with its repulsion. No command
    within the joint bounds can violate a row of a pair beyond. With levers r_j, the distance of a
    part from an axis, a motion D changes a distance by at most sum(r_j |D_j|) exp(sum(|D_j|)); the
    last factor covers levers that grow on the way. The entries of a row are then at most the levers
    and this travel. Pairs whose obstacle moves are always needed.

    Parameters
    ----------
    arm
        An :class:`Arm`. The poses in the data must be those of the present posture.
    case
        A :class:`BrakingCase`. Its brake's `advance` is overwritten by an upper bound.
    needed
        To be filled.
    """
    low, high, braking, options = case.low, case.high, case.braking, case.options
    pairs, moves, twists = arm.chain.pairs, arm.chain.moves, arm.chain.twists
    n, dt = len(case.q), options[DT]
    levers = _levers(arm, n)
    change, fastest, way = np.empty(n), np.empty(n), np.empty(n)
    turned = rest = 0.0
    for column in range(n):
        b = braking.command[column]
        fastest[column] = max(abs(low[column]), abs(high[column]), abs(b))
        advance = 3.0 * dt + fastest[column] / case.limits[column, ACCELERATION]
        braking.advance[column] = advance
        change[column] = advance * max(abs(high[column] - b), abs(b - low[column]))
        way[column] = abs(braking.stop[column] - case.q[column])
        turned += way[column]
        rest += change[column]
    stretch = math.exp(turned)
    for pair in range(len(pairs)):
        a, b = pairs[pair, 0], pairs[pair, 1]
        travel = swept = closing = 0.0
        scale = pairs[pair, 2] / FULL_SCALE
        for column in range(n):
            if moves[a, column] != moves[b, column]:
                lever = scale * (levers[a, column] + levers[b, column])
                travel += lever * way[column]
                swept += lever * change[column]
                closing += lever * fastest[column]
        travel *= stretch
        slack = (APPROACHING + SLACK) * dt
        beyond = options[MARGIN] + travel + (swept + travel * rest + slack) / options[DAMPER]
        moving = 0.0
        for column in range(3, 9):
            moving += abs(twists[b, column])
        if moving > 0.0:
            beyond = np.inf
        needed[0, pair] = beyond
        now = options[MARGIN] + (closing * dt + slack) / options[DAMPER]
        needed[1, pair] = max(options[INFLUENCE], beyond, now)


@njit(cache=True)
def _levers(arm, n):
    """Return the largest distance of each geom from the axis of each joint that moves it, m."""
    moves, joints, shapes = arm.chain.moves, arm.chain.joints, arm.world.shapes
    levers = np.zeros((len(moves), n))
    for geom in range(len(moves)):
        for column in range(n):
            if moves[geom, column]:
                levers[geom, column] = shapes[geom, BOUND] + _axis_distance(
                    arm.world.positions[geom], arm.chain.anchors, arm.chain.axes, joints[column]
                )
    return levers


@njit(cache=True)
def _axis_distance(point, anchors, axes, joint):
    """Return the distance of a point (3,) from a hinge axis, m; 1 for a slide joint."""
    if joint[2] != 1:
        return 1.0
    index = joint[1]
    x, y, z = (
        point[0] - anchors[index, 0], point[1] - anchors[index, 1], point[2] - anchors[index, 2],
    )  # fmt: skip
    along = x * axes[index, 0] + y * axes[index, 1] + z * axes[index, 2]
    return math.sqrt(max(x * x + y * y + z * z - along * along, 0.0))

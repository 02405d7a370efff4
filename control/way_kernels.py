"""The distances on the way to standstill, for the pairs that can bound a command there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .braking_kernels import brake_cycles, braked_posture
from .distance_bounds import APPROACHING, Chain, bounds_at_stop, distance_rows, limit_approach
from .kinematics_kernels import set_posture
from .packed_options import DAMPER, DT, MARGIN
from .proximity_kernels import NEAR_COLUMNS, measure_near, update_held_geoms
from .proximity_tables import BOUND, World
from .safety_kernels import SLACK

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
    spheres: NDArray[np.float64]
    covers: NDArray[np.int64]


@njit(cache=True)
def add_way_bounds(arm, near, case, approached, count, bounds, used):
    """Add the bounds by the distances on the way to standstill; return the number of rows in use.

    Parameters
    ----------
    arm
        An :class:`Arm`. The poses in the data must be those of the present posture.
    near
        Rows of `measure_near` in this posture.
    case
        A :class:`BrakingCase`.
    approached
        Whether an obstacle approaches. All pairs are then measured.
    count
        Number of postures, see `way_postures`.
    bounds, used
        :class:`DistanceBounds`, and the number of its rows in use.
    """
    world, chain, n = arm.world, arm.chain, len(case.q)
    chosen = np.arange(len(chain.pairs))
    if not approached:
        chosen = chosen[: relevant_pairs(near, arm, case, chosen)]
    if len(chosen) == 0:
        return used
    pairs = np.empty((len(chosen), 2), np.int64)
    for k in range(len(chosen)):
        pairs[k, 0], pairs[k, 1] = chain.pairs[chosen[k], 0], chain.pairs[chosen[k], 1]
    every, rows = np.empty((len(chosen), NEAR_COLUMNS)), np.empty((len(chosen), n))
    drifts, posture, dt = np.empty(len(chosen)), np.empty(n), case.options[DT]
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
        there = every[: measure_near(every, world, pairs, arm.covers, arm.spheres)]
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
def relevant_pairs(near, arm, case, chosen):
    """Fill the pairs that can bound the command on the way to standstill; return their number.

    A pair is left out if no command within the joint bounds (n,) can violate its row. With levers
    r_j, the distance of a part from an axis, a motion D changes a distance by at most
    sum(r_j |D_j|) exp(sum(|D_j|)); the last factor covers levers that grow on the way. The entries
    of a row are then at most the levers and this travel.

    Parameters
    ----------
    near
        Rows of `measure_near` in this posture, for which the poses in the data must be.
    arm
        A robot among obstacles, see :class:`Arm`.
    chosen
        (pairs,), to be filled.
    """
    q, low, high, braking, options = case.q, case.low, case.high, case.braking, case.options
    pairs, joints, moves = arm.chain.pairs, arm.chain.joints, arm.chain.moves
    shapes, positions = arm.world.shapes, arm.world.positions
    n = len(q)
    levers = np.zeros((len(moves), n))
    for geom in range(len(moves)):
        for column in range(n):
            if moves[geom, column]:
                levers[geom, column] = shapes[geom, BOUND] + _axis_distance(
                    positions[geom], arm.chain.anchors, arm.chain.axes, joints[column]
                )
    distances = np.full(len(pairs), arm.world.cut_off)
    for row in range(len(near)):
        distances[int(near[row, 0])] = near[row, 1]
    turned = 0.0
    change = np.empty(n)
    for column in range(n):
        turned += abs(braking.stop[column] - q[column])
        b = braking.command[column]
        change[column] = braking.advance[column] * max(abs(high[column] - b), abs(b - low[column]))
    stretch = math.exp(turned)
    count = 0
    for pair in range(len(pairs)):
        a, b = pairs[pair, 0], pairs[pair, 1]
        travel = swept = rest = 0.0
        for column in range(n):
            if moves[a, column] != moves[b, column]:
                lever = levers[a, column] + levers[b, column]
                travel += lever * abs(braking.stop[column] - q[column])
                swept += lever * change[column]
                rest += change[column]
        travel *= stretch
        left = distances[pair] - travel - options[MARGIN]
        used = swept + travel * rest + (APPROACHING + SLACK) * options[DT]
        if arm.covers[a, 1] > 0 or used > options[DAMPER] * left:
            chosen[count] = pair
            count += 1
    return count


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

"""One control cycle in one compiled call: from joint positions to joint velocities.

Poses are computed once for tasks and distances. The kernel returns UNSETTLED if not all bounds can
be satisfied, or a number is not finite. The caller then runs the same functions step by step
(:mod:`motion_steps`), which report the cause.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .braking_kernels import Brake, advance_of, joint_bounds
from .distance_bounds import (
    BrakingCase,
    Chain,
    DistanceBounds,
    bounds_at_stop,
    bounds_now,
    distance_rows,
    limit_approach,
)
from .kinematics_kernels import point_jacobian, set_posture
from .packed_options import CENTRING, DT, FRAME_SPEED, SAFETY
from .proximity_kernels import NEAR_COLUMNS, measure_near, update_held_geoms
from .proximity_tables import World
from .qp_kernels import solve_qp
from .relaxation import relax
from .repulsion import limit_gradient, repel
from .safety_kernels import SafetyRows, deviation_cost, satisfies
from .stack_kernels import Levels, solve_levels
from .tasks.joint_centring import centring_slope
from .tasks.kernel_task import TASK_ROWS, Frame, Output
from .tasks.registry import MISFIT, evaluate_task
from .way_kernels import Arm, add_way_bounds, needed_distances, way_postures

UNSETTLED = -1
"""Return value of the kernel if the cycle has to be computed step by step."""
RECOVERIES = (0.5, 0.2, 0.0)
"""Fractions of the recovery speed that are tried if the whole is not possible."""
CENTRING_POWER = 4.0
"""Power p of the cost that keeps joints near the middle of their ranges (eq. 5), even. A higher
power acts less near the middle, and more near the limits."""


class Distances(NamedTuple):
    """The distances in a posture: what `measure_near` and `distance_rows` fill."""

    near: NDArray[np.float64]
    rows: NDArray[np.float64]
    drifts: NDArray[np.float64]


class Stack(NamedTuple):
    """The tasks of a cycle, for kernels."""

    tasks: NDArray[np.float64]
    """(K, columns), see `registry.pack_tasks`."""
    driven: int
    """Number of tasks in the stack, the first ones. For the others, only the error is computed."""
    options: NDArray[np.float64]
    """See :mod:`packed_options`."""


@njit(cache=True)
def control_cycle(
    q,
    motion,
    command,
    report,
    tasks,
    driven,
    options,
    limits,
    origin,
    frame_axes,
    frame_moves,
    model,
    data,
    qpos,
    anchors,
    axes,
    body_positions,
    body_axes,
    positions,
    matrices,
    joints,
    moves,
    shapes,
    twists,
    pairs,
    held,
    cut_off,
):
    """Compute the joint velocities for packed tasks among obstacles.

    The arguments are a flat list because Python calls this function once per cycle. Two named
    tuples of eight arrays take 2.6 times as long to pass as sixteen arrays (40 against 15 µs on a
    loaded machine). The functions called from here take named tuples.

    Parameters
    ----------
    q
        (n,), finite.
    motion
        (2, n): velocity of the last command, and its acceleration.
    command
        (2, n), to be filled: velocity, rad/s, and acceleration.
    report
        (1 + 2 K + 2 n,), to be filled: the clearance; the unmet error of each task; β of each task;
        the active bounds (a joint, or n + a pair); their Lagrange multipliers.
    tasks, driven, options
        See :class:`Stack`.
    limits
        (n, 5): lower and upper joint limits, joint speeds, accelerations and jerks.
    origin, frame_axes, frame_moves
        Of the controlled frame: views (3,) and (9,) of the data; whether each joint moves it, (n,).
    model to cut_off
        See `proximity_tables.kernel_arguments`.

    Returns
    -------
    Number of active bounds, or UNSETTLED.
    """
    n = len(q)
    chain = Chain(pairs, anchors, axes, joints, moves, twists)
    set_posture(model, data, q, qpos, joints[:, 0])
    # One block for many vectors, because an allocation takes longer than most steps below.
    block = np.zeros((20, n))
    point_jacobian(origin, joints[:, 1], joints[:, 2], frame_moves, anchors, axes, block[:6])
    frame = Frame(q, limits, origin, frame_axes, block[:6], block[6:12])
    world = World(model, data, positions, matrices, shapes, cut_off)
    arm = Arm(world, chain, qpos, held, body_positions, body_axes)
    near = np.empty((len(pairs), NEAR_COLUMNS))
    update_held_geoms(held, body_positions, body_axes, positions, matrices)
    braking = Brake(block[15], block[16], block[17])
    ends, needed = np.empty((2, n)), np.empty((2, len(pairs)))
    joint_bounds(q, motion, limits, options, True, ends[0], ends[1], braking)
    case = BrakingCase(q, motion, limits, ends[0], ends[1], braking, options)
    needed_distances(arm, case, needed)
    near = near[: measure_near(near, world, pairs, needed[1])]
    rows, drifts = np.empty((len(pairs), n)), np.empty(len(pairs))
    distance_rows(near, chain, rows, drifts)
    report[0] = np.inf
    for row in range(len(near)):
        report[0] = min(report[0], near[row, 1])
    nominal = block[14]
    stack = Stack(tasks, driven, options)
    near_rows = rows[: len(near)]
    levels = _nominal_motion(stack, frame, near[:, 1], near_rows, block[12:14], nominal, report)
    if levels.sizes[0] == MISFIT:
        return UNSETTLED
    limit_frame_speed(nominal, frame.jacobian, options[FRAME_SPEED])
    errors = report[1 : 1 + len(tasks)]
    finite = nominal.sum() + errors.sum() + near[:, 1].sum()
    if not math.isfinite(finite + near_rows.sum() + drifts[: len(near)].sum()):
        return UNSETTLED
    active = report[1 + 2 * len(tasks) :]
    distances = Distances(near, rows, drifts)
    count = _commanded(arm, case, levels, distances, needed[0], block[14:], active)
    command[0] = block[19]
    for joint in range(n):
        command[1, joint] = (command[0, joint] - motion[0, joint]) / options[DT]
    return count


@njit(cache=True)
def _commanded(arm, case, levels, distances, needed, block, active):
    """Compute the command from the nominal velocity, within all bounds.

    Parameters
    ----------
    case
        A :class:`BrakingCase`, whose brake's `advance` is filled.
    needed
        (pairs,), see `needed_distances`.
    block
        (6, n): the nominal velocity; three rows for the :class:`Brake`; one row for scratch; the
        command, to be filled.
    active
        (2 n,), to be filled, see `control_cycle`.

    Returns
    -------
    Number of active bounds, or UNSETTLED.
    """
    near, rows, drifts = distances
    q, motion, limits, low, high, braking, options = case
    n, pairs = len(q), arm.chain.pairs
    nominal, velocity = block[0], block[5]
    if options[SAFETY] == 0.0:
        towards(braking.command, nominal, low, high, velocity)
        return 0
    advance_of(nominal, low, high, q, motion, limits, options, braking)
    count = way_postures(q, braking.stop)
    size = 3 * len(near) + max(count, 1) * len(pairs)
    bounds = DistanceBounds(
        np.empty((size, n)), np.empty(size), np.empty(size), np.empty(size, np.int64)
    )
    used = 0
    limit_approach(near[:, 1], rows, drifts, limits, options)
    if count > 0:
        used = bounds_now(near, rows, drifts, case, bounds, used)
        used = add_way_bounds(arm, near, case, needed, count, bounds, used)
    else:
        used = bounds_at_stop(near, rows, drifts, np.inf, case, bounds, used)
    bounds = DistanceBounds(
        bounds.rows[:used], bounds.min_rates[:used], bounds.least_rates[:used], bounds.pairs[:used]
    )
    if satisfies(nominal, SafetyRows(low, high, bounds.rows, bounds.min_rates)):
        velocity[:] = nominal
        return 0
    cost = deviation_cost(levels.sizes, levels.rows)
    count = _safe(nominal, cost, bounds, 1.0, low, high, velocity, active)
    if count < 0:
        # Not all pairs inside the margin can leave it at the recovery speed.
        joint_bounds(q, motion, limits, options, False, low, high, braking)
    for fraction in RECOVERIES:
        if count < 0:
            count = _safe(nominal, cost, bounds, fraction, low, high, velocity, active)
    return count


@njit(cache=True)
def towards(command, nominal, low, high, velocity):
    """Fill the velocity (n,) from the brake's command towards the nominal one, within the bounds.

    All joints take the same fraction of the way, so that a motion starts in its direction.
    """
    fraction = 1.0
    for joint in range(len(command)):
        wanted = nominal[joint] - command[joint]
        room = (high[joint] if wanted > 0.0 else low[joint]) - command[joint]
        if abs(wanted) > abs(room):
            fraction = min(fraction, abs(room) / abs(wanted))
    for joint in range(len(command)):
        velocity[joint] = command[joint] + fraction * (nominal[joint] - command[joint])


@njit(cache=True)
def limit_frame_speed(velocity, jacobian, limit):
    """Scale a velocity (n,) in place so that the frame is not faster than a limit, m/s."""
    if limit == np.inf:
        return
    square = 0.0
    for axis in range(3):
        along = 0.0
        for joint in range(len(velocity)):
            along += jacobian[axis, joint] * velocity[joint]
        square += along * along
    if square > limit * limit:
        velocity *= limit / math.sqrt(square)


@njit(cache=True)
def _nominal_motion(stack, frame, distance, rows, work, nominal, report):
    """Fill the nominal velocity (n,) and the errors and weights β of the report.

    ``work`` (2, n) must be zero. Return the :class:`Levels` of the stack. If a task is invalid,
    sizes[0] is MISFIT.
    """
    tasks, driven, options = stack
    count, n = len(tasks), len(nominal)
    gradient, free_motion = work[0], work[1]
    limit_gradient(gradient, repel(distance, rows, options, gradient), options)
    max_rows = max(TASK_ROWS, n)
    jacobians, rates = np.empty((count, max_rows, n)), np.empty((count, max_rows))
    sizes, sides = np.zeros(count, np.int64), np.zeros(count, np.int64)
    scratch = np.empty((3, max_rows + driven))
    for task in range(count):
        out = Output(scratch[0], scratch[1], jacobians[task])
        m, side, unmet = evaluate_task(tasks[task], frame, out, rates[task])
        if m == MISFIT:
            sizes[0] = MISFIT
            return Levels(sizes, sides, rates, jacobians)
        report[1 + task] = unmet
        if task < driven:
            sizes[task], sides[task] = m, side
            beta = relax(rates[task, :m], jacobians[task], gradient, options)
            report[1 + count + task] = beta
    for joint in range(n):
        slope = centring_slope(frame.q[joint], frame.limits[joint], CENTRING_POWER, np.nan)
        free_motion[joint] = -options[CENTRING] * slope - gradient[joint]
    levels = Levels(sizes[:driven], sides[:driven], rates[:driven], jacobians[:driven])
    dropped = np.empty(driven, np.bool_)
    solve_levels(levels, free_motion, frame.limits[:, 2], nominal, scratch[2, :driven], dropped)
    return levels


@njit(cache=True)
def _safe(nominal, cost, bounds, recovery, low, high, velocity, report):
    """Fill the safe velocity (n,), and the active bounds with their multipliers (2 n,).

    ``recovery`` is the fraction of the recovery speed that pairs inside the margin must reach.
    """
    n = len(nominal)
    rates = bounds.least_rates + recovery * (bounds.min_rates - bounds.least_rates)
    rows = SafetyRows(low, high, bounds.rows, rates)
    held, strength = np.empty(n, np.int64), np.empty(n)
    active = solve_qp(nominal, cost.copy(), rows, velocity, held, strength)
    if active < 0 or not satisfies(velocity, rows):
        return UNSETTLED
    for k in range(active):
        row = held[k] - n
        report[k] = held[k] if row < 0 else n + bounds.pairs[row]
        report[n + k] = strength[k]
    return active

"""One control cycle in one compiled call: from joint angles to joint velocities.

The same steps as `approach.task_motion` and `safety.safe_motion`, on the same equations; poses are
computed once for tasks and distances. What it cannot settle it says: the caller then takes those.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from .kinematics_kernels import point_jacobian, posture
from .nearest_kernels import solve_qp
from .packed_options import (
    BETA,
    CENTRING,
    CENTRING_POWER,
    DAMPING,
    DT,
    EPSILON,
    ETA,
    INFLUENCE,
    NEAR_SINGULAR,
    SAFETY,
)
from .proximity_kernels import NEAR_COLUMNS, distance_row, measure_near
from .relaxation import LARGEST_BETA
from .safety_kernels import allowed, bending_cost, joint_bounds, least_change
from .stack_kernels import solve_levels
from .task_kernels import UNFIT, centring_slope, task_of

UNSETTLED = -1
"""Number of bounds that hold back which says: not all can be kept, or a number is not finite."""


@njit(cache=True)
def control_cycle(
    q,
    velocity,
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
    sizes,
    joints,
    moves,
    shapes,
    motion,
    pairs,
    held,
    balls,
    covers,
    probe,
    sharpness,
    cut_off,
):
    """Joint velocities for packed tasks among obstacles.

    Parameters
    ----------
    q
        (n,), finite.
    velocity
        (n,), to be filled, rad/s.
    report
        (1 + 2 K + 2 n,), to be filled: clearance; by task, the norm of the error that counts; by
        task, β; what holds the velocity back, a joint or n + a pair; its multipliers.
    tasks
        (K, columns), see :mod:`packed_aims`.
    driven
        The first so many tasks are the stack; of the others only the errors are told.
    options
        See :mod:`packed_options`.
    limits
        (n, 3): lower and upper joint limits, joint speeds.
    origin, frame_axes, frame_moves
        Of the controlled frame: views (3,) and (9,) of the data; which joint moves it, (n,).
    model to cut_off
        See `proximity_kernels.near_pairs`.

    Returns
    -------
    Number of bounds that hold the velocity back, or UNSETTLED.
    """
    n, count = len(q), len(tasks)
    posture(model, data, q, qpos, joints[:, 0])
    # One block for many vectors: asking for memory takes longer than most of what follows.
    block = np.zeros((18, n))
    jacobian, work, gradient, free_motion = block[:6], block[6:12], block[12], block[13]
    nominal, low, high, strength = block[14], block[15], block[16], block[17]
    point_jacobian(origin, joints[:, 1], joints[:, 2], frame_moves, anchors, axes, jacobian)
    near = np.empty((len(pairs), NEAR_COLUMNS))
    measured = measure_near(
        near,
        model,
        data,
        body_positions,
        body_axes,
        positions,
        matrices,
        sizes,
        shapes,
        pairs,
        held,
        balls,
        covers,
        probe,
        sharpness,
        cut_off,
    )
    rows, least = np.empty((measured, n)), np.empty(measured)
    for row in range(measured):
        pair = pairs[int(near[row, 0])]
        drift = distance_row(near[row], pair, anchors, axes, joints, moves, motion, rows[row])
        least[row] = least_change(near[row, 1], drift, options)
    report[0] = _repel(near[:measured, 1], rows, options, gradient)

    most = max(6, n)
    task_jacobians, rates, error = (
        np.empty((count, most, n)),
        np.empty((count, most)),
        np.empty(most),
    )
    heights, sides = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for task in range(count):
        m, side, unmet = task_of(
            tasks[task],
            q,
            limits,
            origin,
            frame_axes,
            jacobian,
            work,
            error,
            rates[task],
            task_jacobians[task],
        )
        if m == UNFIT:
            return UNSETTLED
        report[1 + task] = unmet
        if task < driven:
            heights[task], sides[task] = m, side
            report[1 + count + task] = _relax(
                rates[task, :m], task_jacobians[task], gradient, options
            )
    for joint in range(n):
        slope = centring_slope(q[joint], limits[joint], options[CENTRING_POWER], np.nan)
        free_motion[joint] = -options[CENTRING] * slope - gradient[joint]
    solve_levels(
        heights[:driven],
        sides[:driven],
        rates[:driven],
        task_jacobians[:driven],
        free_motion,
        limits[:, 2],
        options[NEAR_SINGULAR],
        options[DAMPING],
        nominal,
    )
    if not _finite(nominal, report[1 : 1 + count], rows, least, near[:measured, 1]):
        return UNSETTLED
    if options[SAFETY] == 0.0:
        for joint in range(n):
            velocity[joint] = min(max(nominal[joint], -limits[joint, 2]), limits[joint, 2])
        return 0
    joint_bounds(q, limits, options, low, high)
    if allowed(nominal, low, high, rows, least):
        velocity[:] = nominal
        return 0
    held_by = np.empty(n, np.int64)
    cost = bending_cost(heights[:driven], task_jacobians[:driven], options)
    active = solve_qp(nominal, cost, low, high, rows, least, velocity, held_by, strength)
    if active < 0 or not allowed(velocity, low, high, rows, least):
        return UNSETTLED
    first = 1 + 2 * count
    for k in range(active):
        row = held_by[k] - n
        report[first + k] = held_by[k] if row < 0 else n + near[row, 0]
        report[first + n + k] = strength[k]
    return active


@njit(cache=True)
def _repel(distance, rows, options, gradient):
    """Fill the tempered gradient (n,), see `repulsion.limited_gradient`; the least distance."""
    clearance, square = np.inf, 0.0
    eta = options[ETA]
    for row in range(len(rows)):
        clearance = min(clearance, distance[row])
        depth = options[INFLUENCE] - distance[row]
        if depth > 0.0:
            for joint in range(len(gradient)):
                gradient[joint] -= 2.0 * eta * depth * rows[row, joint]
                square += rows[row, joint] * rows[row, joint]
    gain = 2.0 * eta * options[DT] * square
    if gain > 1.0:
        gradient /= gain
    return clearance


@njit(cache=True)
def _relax(rate, rows, gradient, options):
    """Bend a task's rate (m,) by avoidance, in place (eq. 8-10); the weight β."""
    avoidance = np.empty(len(rate))
    push = size = 0.0
    for row in range(len(rate)):
        along = 0.0
        for joint in range(len(gradient)):
            along += rows[row, joint] * gradient[joint]
        avoidance[row] = along
        push += along * along
        size += rate[row] * rate[row]
    beta = options[BETA]
    if math.isnan(beta):
        push, room = math.sqrt(push), max(math.sqrt(size) - options[EPSILON], 0.0)
        beta = 0.0 if room == 0.0 else LARGEST_BETA
        if push * beta > room:
            beta = room / push
    for row in range(len(rate)):
        rate[row] -= beta * avoidance[row]
    return beta


@njit(cache=True)
def _finite(nominal, errors, rows, least, distance):
    """Whether every number is; a sum is not as soon as one is not."""
    total = nominal.sum() + errors.sum() + least.sum() + distance.sum()
    return math.isfinite(total + rows.sum())

"""One control cycle in one compiled call: from joint positions to joint velocities.

Poses are computed once for tasks and distances. The kernel returns UNSETTLED if not all bounds can
be satisfied, or a number is not finite. The caller then runs the same functions step by step
(:mod:`motion_steps`), which report the cause.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .kinematics_kernels import point_jacobian, set_posture
from .packed_options import CENTRING, SAFETY
from .proximity_kernels import NEAR_COLUMNS, distance_row, measure_near, update_held_geoms
from .proximity_tables import World
from .qp_kernels import solve_qp
from .relaxation import relax
from .repulsion import limit_gradient, repel
from .safety_kernels import SafetyRows, deviation_cost, joint_bounds, min_distance_rate, satisfies
from .stack_kernels import Levels, solve_levels
from .tasks.joint_centring import centring_slope
from .tasks.kernel_task import TASK_ROWS, Frame, Output
from .tasks.registry import MISFIT, evaluate_task

if TYPE_CHECKING:
    from numpy.typing import NDArray

UNSETTLED = -1
"""Return value of the kernel if the cycle has to be computed step by step."""
CENTRING_POWER = 4.0
"""Power p of the cost that keeps joints near the middle of their ranges (eq. 5), even. A higher
power acts less near the middle, and more near the limits."""


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
    spheres,
    covers,
    probe,
    sharpness,
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
    velocity
        (n,), to be filled, rad/s.
    report
        (1 + 2 K + 2 n,), to be filled: the clearance; the unmet error of each task; β of each task;
        the active bounds (a joint, or n + a pair); their Lagrange multipliers.
    tasks, driven, options
        See :class:`Stack`.
    limits
        (n, 3): lower and upper joint limits, joint speeds.
    origin, frame_axes, frame_moves
        Of the controlled frame: views (3,) and (9,) of the data; whether each joint moves it, (n,).
    model to cut_off
        See `proximity_tables.kernel_arguments`.

    Returns
    -------
    Number of active bounds, or UNSETTLED.
    """
    n = len(q)
    set_posture(model, data, q, qpos, joints[:, 0])
    # One block for many vectors, because an allocation takes longer than most steps below.
    block = np.zeros((17, n))
    point_jacobian(origin, joints[:, 1], joints[:, 2], frame_moves, anchors, axes, block[:6])
    frame = Frame(q, limits, origin, frame_axes, block[:6], block[6:12])
    world = World(model, data, positions, matrices, sizes, shapes, probe, sharpness, cut_off)
    near = np.empty((len(pairs), NEAR_COLUMNS))
    update_held_geoms(held, body_positions, body_axes, positions, matrices)
    count = measure_near(near, world, pairs, covers, spheres)
    near = near[:count]
    rows, min_rates = np.empty((count, n)), np.empty(count)
    for row in range(count):
        pair = pairs[int(near[row, 0])]
        drift = distance_row(near[row], pair, anchors, axes, joints, moves, motion, rows[row])
        min_rates[row] = min_distance_rate(near[row, 1], drift, options, True)
    clearance = np.inf
    for row in range(count):
        clearance = min(clearance, near[row, 1])
    report[0] = clearance
    nominal = block[14]
    levels = _nominal_motion(
        Stack(tasks, driven, options), frame, near[:, 1], rows, block[12:14], nominal, report
    )
    if levels.sizes[0] == MISFIT:
        return UNSETTLED
    errors = report[1 : 1 + len(tasks)]
    if not math.isfinite(
        nominal.sum() + errors.sum() + min_rates.sum() + near[:, 1].sum() + rows.sum()
    ):
        return UNSETTLED
    if options[SAFETY] == 0.0:
        for joint in range(n):
            velocity[joint] = min(max(nominal[joint], -limits[joint, 2]), limits[joint, 2])
        return 0
    bounds = SafetyRows(block[15], block[16], rows, min_rates)
    joint_bounds(q, limits, options, True, bounds.low, bounds.high)
    if satisfies(nominal, bounds):
        velocity[:] = nominal
        return 0
    cost = deviation_cost(levels.sizes, levels.rows)
    return _safe(nominal, cost, bounds, near[:, 0], velocity, report[1 + 2 * len(tasks) :])


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
def _safe(nominal, cost, bounds, pairs, velocity, report):
    """Fill the safe velocity (n,), and the active bounds with their multipliers (2 n,)."""
    n = len(nominal)
    held, strength = np.empty(n, np.int64), np.empty(n)
    active = solve_qp(nominal, cost, bounds, velocity, held, strength)
    if active < 0 or not satisfies(velocity, bounds):
        return UNSETTLED
    for k in range(active):
        row = held[k] - n
        report[k] = held[k] if row < 0 else n + pairs[row]
        report[n + k] = strength[k]
    return active

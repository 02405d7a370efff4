"""The safety level above all tasks: it keeps distances and all limits of the joints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import daqp
import numpy as np

from .braking import bounding_pairs, command_rows
from .qp_kernels import TOLERANCE
from .safety_kernels import TASK_WEIGHT, SafetyRows, satisfies

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .braking import Braking
    from .options import ControlOptions
    from .proximity import Proximity
    from .robot_state import RobotState

UNBOUNDED = 1e30
"""Value that represents infinity in the solver."""
VIOLATION_COST = 1e6
"""Cost of a squared violation, (m/s)^-2. The cost of a squared joint speed is 1, so the nominal
motion has practically no weight against a violation."""
ACTIVE = 1e-9
"""Minimum Lagrange multiplier of a constraint that is reported as blocking."""
NEAR_LIMIT = 0.1
"""A blocked joint nearer to its limit than this is reported as blocked by the limit, rad or m;
otherwise by its speed limit."""


@dataclass(frozen=True)
class SafeMotion:
    """The safe joint velocities nearest to the nominal ones."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    blocking: tuple[str, ...]
    """Names of the active constraints, strongest first: pairs of parts, joints at a limit."""
    feasible: bool
    """False if not all constraints can be satisfied, for example when an obstacle approaches too
    fast. The violation is then as small as possible."""


def safe_motion(
    nominal: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    options: ControlOptions,
    joint_names: Sequence[str] = (),
    braking: Braking | None = None,
) -> SafeMotion:
    """Return the safe joint velocity nearest to a nominal one (n,), rad/s.

    The cost is |velocity - nominal|² + w |J (velocity - nominal)|², with the rows J (m, n) of the
    tasks and w = TASK_WEIGHT. So the change affects the tasks as little as possible. If not all
    pairs inside the margin can leave it at the recovery speed, no pair goes deeper, and each leaves
    as fast as it can. An input that is not finite brakes the robot.

    With ``braking``, the limits of acceleration and jerk are kept. Without it, the joints may
    change their velocity at once.
    """
    stop = np.zeros(len(state.q)) if braking is None else braking.command
    invalid = _not_finite(nominal, task_rows, proximity, state)
    for _, there in () if braking is None else braking.on_way:
        invalid += _not_finite(nominal, task_rows, there, state)
    if invalid:
        return SafeMotion(stop, tuple(dict.fromkeys(invalid)), False)
    rows = command_rows(nominal, state, proximity, options, braking, recover=True)
    if satisfies(nominal, rows):
        return SafeMotion(nominal, (), True)
    hessian = np.eye(len(nominal)) + TASK_WEIGHT * task_rows.T @ task_rows
    velocity, multipliers = _solve_hard(nominal, hessian, rows)
    feasible = velocity is not None and satisfies(velocity, rows)
    if velocity is None or not feasible:
        least = command_rows(nominal, state, proximity, options, braking, recover=False)
        velocity, multipliers, feasible = _solve_no_recovery(nominal, hessian, least, rows, stop)
    names = joint_names or [str(joint + 1) for joint in range(len(nominal))]
    joints = list(zip(names, state.lower.tolist(), state.upper.tolist(), strict=True))
    ranked = [(value, index) for index, value in enumerate(multipliers.tolist())]
    labels = [f"{first} near {second}" for first, second in bounding_pairs(proximity, braking)]
    blocking = blocking_names(ranked, state.q, joints, labels)
    return SafeMotion(velocity, blocking, feasible)


def blocking_names(
    multipliers: Sequence[tuple[float, int]],
    q: NDArray[np.float64],
    joints: Sequence[tuple[str, float, float]],
    pairs: Sequence[str],
) -> tuple[str, ...]:
    """Return the names of the active constraints, strongest first.

    Parameters
    ----------
    multipliers
        Lagrange multiplier and index of each constraint: a joint, or n + a pair.
    q
        Joint positions (n,).
    joints
        Name, lower and upper limit of each joint.
    pairs
        Name of each pair.
    """
    names = []
    for multiplier, index in sorted(multipliers, reverse=True):
        if multiplier < ACTIVE:
            break
        if index >= len(joints):
            name = pairs[index - len(joints)]
            # A pair may be active both now and at standstill.
            if name not in names:
                names.append(name)
        else:
            name, lower, upper = joints[index]
            position = float(q[index])
            near = min(position - lower, upper - position) < NEAR_LIMIT
            names.append(f"joint {name} at its {'limit' if near else 'full speed'}")
    return tuple(names)


def _solve_no_recovery(
    nominal: NDArray[np.float64],
    hessian: NDArray[np.float64],
    no_recovery: SafetyRows,
    rows: SafetyRows,
    stop: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Satisfy the bounds without recovery, and violate the others as little as possible.

    If the bounds without recovery conflict too, only those of the joints are satisfied. ``stop``
    (n,) is the command of the brake.

    Returns
    -------
    velocity (n,), multipliers (n + P,), whether the bounds without recovery are satisfied.
    """
    velocity, multipliers = _solve_soft(nominal, hessian, no_recovery, rows)
    if velocity is None or not satisfies(velocity, no_recovery):
        # If no obstacle moves, only rounding leads here, because the costs differ so much.
        velocity, multipliers = _solve_hard(nominal, hessian, no_recovery)
    if velocity is not None and satisfies(velocity, no_recovery):
        return velocity, multipliers, True
    if satisfies(stop, no_recovery):
        return stop, multipliers, True
    only_joints = no_recovery._replace(min_rates=np.full_like(no_recovery.min_rates, -UNBOUNDED))
    velocity, multipliers = _solve_soft(nominal, hessian, only_joints, no_recovery)
    if velocity is None:
        return stop, multipliers, False
    return np.clip(velocity, no_recovery.low, no_recovery.high), multipliers, False


def _bounds(rows: SafetyRows) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lower and upper bounds (n + P,) of joints and pairs."""
    high = np.concatenate([rows.high, np.full(len(rows.min_rates), UNBOUNDED)])
    return np.concatenate([rows.low, rows.min_rates]), high


def _solve_hard(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], rows: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Return the velocity (n,) and the multipliers (n + P,); no velocity if infeasible."""
    return _solve(hessian, -hessian @ nominal, rows.rows, *_bounds(rows))


def _solve_soft(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], hard: SafetyRows, soft: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Satisfy the bounds `hard`, and violate the tighter bounds `soft` as little as possible.

    Each tighter bound gets a slack variable. The solver's own soft constraints are not used,
    because they weigh the violation of a row by the row's length.
    """
    joints, pairs = len(nominal), len(hard.min_rates)
    all_rows = np.concatenate([np.eye(joints), hard.rows])
    (hard_low, hard_high), (low, high) = _bounds(hard), _bounds(soft)
    tighter = np.flatnonzero((low > hard_low) | (high < hard_high))
    extra = len(tighter)
    size = joints + extra
    weights = np.zeros((size, size))
    weights[:joints, :joints] = hessian
    weights[joints:, joints:] = VIOLATION_COST * np.eye(extra)
    constraints = np.zeros((pairs + extra, size))
    constraints[:pairs, :joints] = hard.rows
    constraints[pairs:, :joints] = all_rows[tighter]
    constraints[pairs:, joints:] = np.eye(extra)
    free = np.full(extra, UNBOUNDED)
    velocity, multipliers = _solve(
        weights,
        np.concatenate([-hessian @ nominal, np.zeros(extra)]),
        constraints,
        np.concatenate([hard.low, -free, hard.min_rates, low[tighter]]),
        np.concatenate([hard.high, free, hard_high[joints:], high[tighter]]),
    )
    total = np.concatenate([multipliers[:joints], multipliers[size : size + pairs]])
    total[tighter] += multipliers[size + pairs :]
    return None if velocity is None else velocity[:joints], total


def _solve(
    hessian: NDArray[np.float64],
    linear: NDArray[np.float64],
    rows: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Minimise ½ xᵀHx + linear x; return x and the absolute multipliers, or None if infeasible."""
    sense = np.zeros(len(low), dtype=np.int32)
    x, _, flag, info = daqp.solve(hessian, linear, rows, high, low, sense, primal_tol=TOLERANCE)
    x = np.asarray(x, dtype=np.float64)
    if flag < 1 or not math.isfinite(np.vdot(x, x)):
        return None, np.zeros(len(low))
    return x, np.abs(np.asarray(info["lam"], dtype=np.float64))


def _not_finite(
    nominal: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    proximity: Proximity,
    state: RobotState,
) -> tuple[str, ...]:
    """Return the names of inputs that are not finite. The solver would ignore their bounds."""
    limits = np.concatenate([state.q, state.lower, state.upper, state.speed])
    if not np.isnan(limits).any() and all(
        # The dot product is finite only if all entries are. It is faster than np.isfinite.
        math.isfinite(np.vdot(array, array))
        for array in (nominal, task_rows, proximity.rows, proximity.distance, proximity.drift)
    ):
        return ()
    names = [] if np.all(np.isfinite(nominal)) else ["the nominal velocity is not finite"]
    if not np.all(np.isfinite(task_rows)):
        names.append("the rows of the tasks are not finite")
    numbers = np.column_stack([proximity.rows, proximity.distance, proximity.drift])
    for (first, second), finite in zip(proximity.names, np.isfinite(numbers), strict=True):
        if not finite.all():
            names.append(f"the distance of {first} and {second} is not finite")
    return tuple(names) or ("a joint limit or a joint speed is not a number",)

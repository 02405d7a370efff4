"""The safety level above all tasks: no nominal motion passes a distance, a joint limit, a speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import daqp
import numpy as np

from .packed_options import pack_options
from .qp_kernels import TOLERANCE
from .safety_kernels import TASK_WEIGHT, SafetyRows, allowed, joint_bounds, min_distance_rate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .options import ControlOptions
    from .proximity import Proximity
    from .robot_state import RobotState

UNBOUNDED = 1e30
"""Value that represents infinity in the solver."""
GIVING_WAY = 1e6
"""Cost of a squared violation, (m/s)^-2, beside 1 of a squared joint speed: the nominal motion
weighs nothing against it."""
ACTIVE = 1e-9
"""Multipliers above this mark a constraint that holds the motion back."""
NEAR_LIMIT = 0.1
"""A joint held back this near its limit is held by the limit, rad or m; else by its speed."""


@dataclass(frozen=True)
class SafeMotion:
    """Joint velocities that keep what must be kept, nearest to the nominal ones."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    blocking: tuple[str, ...]
    """Active constraints, strongest first: pairs of parts, joints at a limit."""
    feasible: bool
    """False when what must be kept cannot all be kept, an obstacle moving in, say; the velocity is
    then the least violation."""


def safety_rows(
    state: RobotState, proximity: Proximity, options: ControlOptions, *, recover: bool = True
) -> SafetyRows:
    """Return the velocity dampers (Faverjon and Tournassoud 1987) in discrete time.

    One cycle may use up a share of the distance left to the margin, so the margin is approached
    and not passed. Inside it the distance must grow, or with `recover` false at least not shrink:
    without moving obstacles standing still then keeps every bound.
    """
    packed = pack_options(options)
    low, high = np.empty(len(state.q)), np.empty(len(state.q))
    limits = np.column_stack([state.lower, state.upper, state.speed]).astype(np.float64)
    joint_bounds(np.asarray(state.q, dtype=np.float64), limits, packed, recover, low, high)
    min_rates = [
        min_distance_rate(distance, drift, packed, recover)
        for distance, drift in zip(
            proximity.distance.tolist(), proximity.drift.tolist(), strict=True
        )
    ]
    return SafetyRows(low, high, proximity.rows, np.array(min_rates, dtype=np.float64))


def safe_motion(
    nominal: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    options: ControlOptions,
    joint_names: Sequence[str] = (),
) -> SafeMotion:
    """Return the safe joint velocity nearest to a nominal one (n,), rad/s.

    Nearest means the least |velocity - nominal|² + w |J (velocity - nominal)|², with J (m, n) the
    rows of the tasks and w = TASK_WEIGHT: the change goes where the tasks feel it least. When not
    all pairs inside the margin can leave it at the recovery speed, none goes deeper, and each
    leaves as fast as it can. A number that is not finite stops the robot.
    """
    rows = safety_rows(state, proximity, options)
    lost = _not_finite(nominal, task_rows, proximity, state)
    if lost:
        return SafeMotion(np.zeros(len(rows.low)), lost, False)
    if allowed(nominal, rows):
        return SafeMotion(nominal, (), True)
    hessian = np.eye(len(nominal)) + TASK_WEIGHT * task_rows.T @ task_rows
    velocity, strength = _nearest(nominal, hessian, rows)
    if velocity is not None and allowed(velocity, rows):
        return SafeMotion(velocity, _blocking(strength, state, proximity, joint_names), True)
    still = safety_rows(state, proximity, options, recover=False)
    velocity, strength, feasible = _without_recovery(nominal, hessian, still, rows)
    return SafeMotion(velocity, _blocking(strength, state, proximity, joint_names), feasible)


def near_pair(names: tuple[str, str]) -> str:
    """Return the name of a constraint between two near parts."""
    return f"{names[0]} near {names[1]}"


def held_joint(name: str, q: float, lower: float, upper: float) -> str:
    """Return the name of a joint constraint."""
    near = min(q - lower, upper - q) < NEAR_LIMIT
    return f"joint {name} at its {'limit' if near else 'full speed'}"


def _without_recovery(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], still: SafetyRows, rows: SafetyRows
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Keep the bounds `still`, of `rows` what can be; else the speeds, of `still` what can be."""
    velocity, strength = _giving_way(nominal, hessian, still, rows)
    if velocity is None or not allowed(velocity, still):
        # Without a moving obstacle this comes of rounding only: the costs lie far apart.
        velocity, strength = _nearest(nominal, hessian, still)
    if velocity is not None and allowed(velocity, still):
        return velocity, strength, True
    stop = np.zeros_like(nominal)
    if allowed(stop, still):
        return stop, strength, True
    bare = still._replace(min_rates=np.full_like(still.min_rates, -UNBOUNDED))
    velocity, strength = _giving_way(nominal, hessian, bare, still)
    if velocity is None:
        return stop, strength, False
    return np.minimum(np.maximum(velocity, still.low), still.high), strength, False


def _nearest(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], rows: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Velocity and what each joint (n) and each row (P) holds it back with; None: infeasible."""
    high = np.concatenate([rows.high, np.full(len(rows.min_rates), UNBOUNDED)])
    low = np.concatenate([rows.low, rows.min_rates])
    return _solve(hessian, -hessian @ nominal, rows.rows, low, high)


def _giving_way(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], must: SafetyRows, should: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Keep the bounds `must`; of the tighter ones `should`, miss as little as possible.

    Each tighter bound gets a variable that takes up what it misses. The solver's own soft
    constraints would weigh a row by its length: what a short lever misses bends all joints.
    """
    joints, pairs = len(nominal), len(must.min_rates)
    every = np.concatenate([np.eye(joints), must.rows])
    open_end = np.full(pairs, UNBOUNDED)
    low, high = (
        np.concatenate([should.low, should.min_rates]),
        np.concatenate([should.high, open_end]),
    )
    tighter = np.flatnonzero(
        (low > np.concatenate([must.low, must.min_rates]))
        | (high < np.concatenate([must.high, open_end]))
    )
    extra = len(tighter)
    size = joints + extra
    weights = np.zeros((size, size))
    weights[:joints, :joints] = hessian
    weights[joints:, joints:] = GIVING_WAY * np.eye(extra)
    constraints = np.zeros((pairs + extra, size))
    constraints[:pairs, :joints] = must.rows
    constraints[pairs:, :joints] = every[tighter]
    constraints[pairs:, joints:] = np.eye(extra)
    free = np.full(extra, UNBOUNDED)
    velocity, strength = _solve(
        weights,
        np.concatenate([-hessian @ nominal, np.zeros(extra)]),
        constraints,
        np.concatenate([must.low, -free, must.min_rates, low[tighter]]),
        np.concatenate([must.high, free, open_end, high[tighter]]),
    )
    held = np.concatenate([strength[:joints], strength[size : size + pairs]])
    held[tighter] += strength[size + pairs :]
    return None if velocity is None else velocity[:joints], held


def _solve(
    hessian: NDArray[np.float64],
    linear: NDArray[np.float64],
    rows: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Minimum (n,) of ½ xᵀHx + linear x and the size of the multipliers; None: infeasible."""
    sense = np.zeros(len(low), dtype=np.int32)
    x, _, flag, told = daqp.solve(hessian, linear, rows, high, low, sense, primal_tol=TOLERANCE)
    x = np.asarray(x, dtype=np.float64)
    if flag < 1 or not math.isfinite(np.vdot(x, x)):
        return None, np.zeros(len(low))
    return x, np.abs(np.asarray(told["lam"], dtype=np.float64))


def _not_finite(
    nominal: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    proximity: Proximity,
    state: RobotState,
) -> tuple[str, ...]:
    """Return what is not finite, by name: the solver would take it for no bound at all."""
    limits = np.concatenate([state.q, state.lower, state.upper, state.speed])
    if not np.isnan(limits).any() and all(
        # One dot product is finite exactly when all entries are, and costs a third of np.isfinite.
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
    return tuple(names) or ("a joint limit or a joint speed is no number",)


def _blocking(
    strength: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    joint_names: Sequence[str],
) -> tuple[str, ...]:
    joints = len(state.q)
    names = []
    for index in np.argsort(-strength).tolist():
        if strength[index] < ACTIVE:
            break
        if index >= joints:
            names.append(near_pair(proximity.names[index - joints]))
        else:
            name = str(joint_names[index]) if joint_names else str(index + 1)
            place = [float(of[index]) for of in (state.q, state.lower, state.upper)]
            names.append(held_joint(name, *place))
    return tuple(names)

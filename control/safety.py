"""The safety level above all tasks: no nominal motion passes a distance, a joint limit, a speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import daqp
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .options import ControlOptions
    from .proximity import Proximity
    from .robot_state import RobotState

UNBOUNDED = 1e30
"""What the solver takes for infinity."""
TOLERANCE = 1e-10
"""By how much the solver may pass a bound, in rad/s or per unit row; its own 1e-6 would show."""
GIVING_WAY = 1e6
"""Cost of a squared violation, (m/s)^-2, beside 1 of a squared joint speed: the nominal motion
weighs nothing against it."""
ACTIVE = 1e-9
"""Multipliers above this mark a constraint that holds the motion back."""
NEAR_LIMIT = 0.1
"""A joint held back this near its limit is held by the limit, rad or m; else by its speed."""
SLACK = 1e-9
"""Violations below this, in rad/s or m/s, are rounding."""


@dataclass(frozen=True)
class SafeMotion:
    """Joint velocities that keep what must be kept, nearest to the nominal ones."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    blocking: tuple[str, ...]
    """What holds the nominal motion back, strongest first: pairs of parts, joints at a limit."""
    feasible: bool
    """False when what must be kept cannot all be kept, an obstacle moving in, say; the velocity is
    then the least violation."""


@dataclass(frozen=True)
class SafetyRows:
    """Linear bounds on joint velocities: low <= velocity <= high, rows @ velocity >= least."""

    low: NDArray[np.float64]
    """(n,), rad/s."""
    high: NDArray[np.float64]
    """(n,), rad/s."""
    rows: NDArray[np.float64]
    """(P, n) distance rows."""
    least: NDArray[np.float64]
    """(P,), m/s: slowest change of each distance that is allowed."""

    def allow(self, velocity: NDArray[np.float64]) -> bool:
        """Tell whether a velocity (n,) keeps all bounds."""
        return bool(
            (velocity >= self.low - SLACK).all()
            and (velocity <= self.high + SLACK).all()
            and (self.rows @ velocity >= self.least - SLACK).all()
        )


def safety_rows(
    state: RobotState, proximity: Proximity, options: ControlOptions, *, recover: bool = True
) -> SafetyRows:
    """Velocity dampers (Faverjon and Tournassoud 1987) in discrete time.

    One cycle may use up a share of the distance left to the margin, so the margin is approached
    and not passed. Inside it the distance must grow, or with `recover` false at least not shrink:
    without moving obstacles standing still then keeps every bound.
    """
    share = options.damper / options.dt
    left = proximity.distance - options.margin
    back = options.recovery_speed if recover else 0.0
    least = np.where(left >= 0.0, -share * left, np.minimum(-share * left, back))
    below = state.q - (state.lower + options.limit_margin)
    above = (state.upper - options.limit_margin) - state.q
    outside = state.speed if recover else np.zeros_like(state.speed)
    low = np.minimum(np.maximum(-share * below, -state.speed), outside)
    high = np.maximum(np.minimum(share * above, state.speed), -outside)
    # A range narrower than the two margins leaves its middle.
    crossed = low > high
    if crossed.any():
        low[crossed] = high[crossed] = 0.5 * (low[crossed] + high[crossed])
    return SafetyRows(low, high, proximity.rows, least - proximity.drift)


def safe_motion(
    nominal: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    options: ControlOptions,
    joint_names: Sequence[str] = (),
) -> SafeMotion:
    """Find the nearest safe joint velocity to a nominal one (n,), rad/s.

    Nearest in |velocity - nominal|² + task_weight |J (velocity - nominal)|², with J (m, n) the
    rows of the tasks: what must bend, bends where the tasks feel it least. When not all that is
    inside its margin can leave at the speed asked, nothing goes deeper and the rest
    leaves as fast as it can.
    What is not finite stops the robot.
    """
    rows = safety_rows(state, proximity, options)
    lost = _not_finite(nominal, task_rows, proximity, rows)
    if lost:
        return SafeMotion(np.zeros(len(rows.low)), lost, False)
    if rows.allow(nominal):
        return SafeMotion(nominal, (), True)
    hessian = np.eye(len(nominal)) + options.task_weight * task_rows.T @ task_rows
    velocity, strength = _nearest(nominal, hessian, rows)
    if velocity is not None and rows.allow(velocity):
        return SafeMotion(velocity, _blocking(strength, state, proximity, joint_names), True)
    still = safety_rows(state, proximity, options, recover=False)
    velocity, strength, feasible = _without_recovery(nominal, hessian, still, rows)
    return SafeMotion(velocity, _blocking(strength, state, proximity, joint_names), feasible)


def near_pair(names: tuple[str, str]) -> str:
    """What blocks, by name: two parts that are near each other."""
    return f"{names[0]} near {names[1]}"


def held_joint(name: str, q: float, lower: float, upper: float) -> str:
    """What blocks, by name: a joint."""
    near = min(q - lower, upper - q) < NEAR_LIMIT
    return f"joint {name} at its {'limit' if near else 'full speed'}"


def _without_recovery(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], still: SafetyRows, rows: SafetyRows
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Keep the bounds `still`, of `rows` what can be; else the speeds, of `still` what can be."""
    velocity, strength = _giving_way(nominal, hessian, still, rows)
    if velocity is None or not still.allow(velocity):
        # Without a moving obstacle this comes of rounding only: the costs lie far apart.
        velocity, strength = _nearest(nominal, hessian, still)
    if velocity is not None and still.allow(velocity):
        return velocity, strength, True
    stop = np.zeros_like(nominal)
    if still.allow(stop):
        return stop, strength, True
    bare = replace(still, least=np.full_like(still.least, -UNBOUNDED))
    velocity, strength = _giving_way(nominal, hessian, bare, still)
    if velocity is None:
        return stop, strength, False
    return np.minimum(np.maximum(velocity, still.low), still.high), strength, False


def _nearest(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], rows: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Velocity and what each joint (n) and each row (P) holds it back with; None: infeasible."""
    high = np.concatenate([rows.high, np.full(len(rows.least), UNBOUNDED)])
    low = np.concatenate([rows.low, rows.least])
    return _solve(hessian, -hessian @ nominal, rows.rows, low, high)


def _giving_way(
    nominal: NDArray[np.float64], hessian: NDArray[np.float64], must: SafetyRows, should: SafetyRows
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Keep the bounds `must`; of the tighter ones `should`, miss as little as possible.

    Each tighter bound gets a variable that takes up what it misses. The solver's own soft
    constraints would weigh a row by its length: what a short lever misses bends all joints.
    """
    joints, pairs = len(nominal), len(must.least)
    every = np.concatenate([np.eye(joints), must.rows])
    open_end = np.full(pairs, UNBOUNDED)
    low, high = np.concatenate([should.low, should.least]), np.concatenate([should.high, open_end])
    tighter = np.flatnonzero(
        (low > np.concatenate([must.low, must.least]))
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
        np.concatenate([must.low, -free, must.least, low[tighter]]),
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
    rows: SafetyRows,
) -> tuple[str, ...]:
    """What is no finite number, by name: the solver would take it for no bound at all."""
    # Each side by itself: without limits and speeds one is -inf, the other inf.
    if not (math.isnan(rows.low.sum()) or math.isnan(rows.high.sum())) and all(
        # One dot product is finite exactly when all entries are, and costs a third of asking.
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

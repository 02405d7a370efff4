"""The safety level above all tasks: no wish of theirs passes a distance, a joint limit, a speed."""

from __future__ import annotations

from dataclasses import dataclass
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
SOFT = 8
"""The solver's mark of a constraint that gives way when nothing else is possible."""
ACTIVE = 1e-9
"""Multipliers above this mark a constraint that holds the motion back."""
NEAR_LIMIT = 0.1
"""A joint held back this near its limit is held by the limit, rad or m; else by its speed."""
SLACK = 1e-9
"""Violations below this, in rad/s or m/s, are rounding."""


@dataclass(frozen=True)
class SafeMotion:
    """Joint velocities that keep what must be kept, nearest to those wished for."""

    velocity: NDArray[np.float64]
    """(n,), rad/s."""
    blocking: tuple[str, ...]
    """What holds the wish back, strongest first: pairs of parts, joints at a limit."""
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
            np.all(velocity >= self.low - SLACK)
            and np.all(velocity <= self.high + SLACK)
            and np.all(self.rows @ velocity >= self.least - SLACK)
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
    low = np.clip(-share * below, -state.speed, outside)
    high = np.clip(share * above, -outside, state.speed)
    # A range narrower than the two margins leaves its middle.
    crossed = low > high
    middle = 0.5 * (low + high)
    low, high = np.where(crossed, middle, low), np.where(crossed, middle, high)
    return SafetyRows(low, high, proximity.rows, least - proximity.drift)


def safe_motion(
    wish: NDArray[np.float64],
    task_rows: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    options: ControlOptions,
    joint_names: Sequence[str] = (),
) -> SafeMotion:
    """Find the nearest safe joint velocity to a wish (n,), rad/s.

    Nearest in |velocity - wish|² + task_weight |J (velocity - wish)|², with J (m, n) the rows of
    the tasks: what must bend, bends where the tasks feel it least.
    """
    rows = safety_rows(state, proximity, options)
    if rows.allow(wish):
        return SafeMotion(wish, (), True)
    hessian = np.eye(len(wish)) + options.task_weight * task_rows.T @ task_rows
    velocity, multipliers = _nearest(wish, hessian, rows, soft=False)
    if velocity is None:
        rows = safety_rows(state, proximity, options, recover=False)
        velocity, multipliers = _nearest(wish, hessian, rows, soft=False)
    feasible = velocity is not None
    if velocity is None:
        velocity, multipliers = _nearest(wish, hessian, rows, soft=True)
    if velocity is None:
        velocity, multipliers = np.zeros_like(wish), np.zeros(len(wish) + len(rows.least))
    return SafeMotion(velocity, _blocking(multipliers, state, proximity, joint_names), feasible)


def _nearest(
    wish: NDArray[np.float64], hessian: NDArray[np.float64], rows: SafetyRows, *, soft: bool
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    joints, pairs = len(wish), len(rows.least)
    sense = np.zeros(joints + pairs, dtype=np.int32)
    if soft:
        sense[joints:] = SOFT
    velocity, _, flag, told = daqp.solve(
        hessian,
        -hessian @ wish,
        rows.rows,
        np.concatenate([rows.high, np.full(pairs, UNBOUNDED)]),
        np.concatenate([rows.low, rows.least]),
        sense,
    )
    velocity = np.asarray(velocity, dtype=np.float64)
    if flag < 1 or not np.all(np.isfinite(velocity)):
        return None, np.zeros(joints + pairs)
    return velocity, np.asarray(told["lam"], dtype=np.float64)


def _blocking(
    multipliers: NDArray[np.float64],
    state: RobotState,
    proximity: Proximity,
    joint_names: Sequence[str],
) -> tuple[str, ...]:
    joints = len(state.q)
    strength = np.abs(multipliers)
    names = []
    for index in np.argsort(-strength):
        if strength[index] < ACTIVE:
            break
        if index >= joints:
            first, second = proximity.names[index - joints]
            names.append(f"{first} near {second}")
        else:
            name = joint_names[index] if joint_names else str(index + 1)
            room = min(state.q[index] - state.lower[index], state.upper[index] - state.q[index])
            names.append(f"joint {name} at its {'limit' if room < NEAR_LIMIT else 'full speed'}")
    return tuple(names)

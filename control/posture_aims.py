"""Tasks for the posture as a whole: manipulability, and joints near the middle of their range."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from eyehand.errors import InputError

from .aim_fields import number, rates, store, vector
from .interval import bounded
from .task import DEFAULT_GAIN, DEFAULT_TURN_SPEED, TaskRows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .robot_state import RobotState

DEFAULT_GROWTH = 1.0
"""Largest commanded change of manipulability, goals per second: released a third above the goal
with the default gain."""


def _origin() -> NDArray[np.float64]:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class Manipulability:
    """Keep the hand able to move every way: sqrt(det(J Jᵀ)) stays above a goal, 1 row.

    Measure of Yoshikawa (1985), of chosen rows of a point's Jacobian. The value is its share of
    the goal, so that rows are of the size of other tasks' whatever the arm. It is a lower bound
    like :class:`Interval`'s: released well above 1. In a singular posture the measure has a kink,
    and the row is one of the ways out; with two directions lost at once it is zero.

    Raises
    ------
    InputError
        If the goal is not positive, a row is not one of 0..5, a number is not finite, or (by `at`)
        there are fewer joints than rows.
    """

    goal: float
    """Least measure wanted, in the units of the rows' determinant (m³ for six rows)."""
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    """Rows that count: 0 to 2 linear x, y, z, 3 to 5 angular, world axes."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_GROWTH
    """Goals per second."""
    name: str = "manipulability"
    """Name for reports."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        rows = tuple(self.rows)
        if not rows or len(set(rows)) < len(rows) or not set(rows) <= set(range(6)):
            raise InputError(
                f"{self.name}: rows must be different numbers from 0 to 5, got {self.rows}"
            )
        goal = number(self.name, "goal", self.goal)
        if goal <= 0.0:
            raise InputError(f"{self.name}: goal must be > 0, got {self.goal}")
        store(self, goal=goal, rows=rows, point=vector(self.name, "point", self.point))

    def at(self, state: RobotState) -> TaskRows:
        """Value: the measure over the goal, (1,)."""
        if len(state.q) < len(self.rows):
            raise InputError(
                f"{self.name}: {len(self.rows)} rows need as many joints, got {len(state.q)}"
            )
        _, linear = state.point(self.point)
        jacobian = np.concatenate([linear, state.jacobian[3:]])
        order = state.from_base
        if order is None:
            measure, gradient = manipulability(jacobian, self.rows)
        else:
            gradient = np.empty(len(order))
            measure, gradient[order] = manipulability(jacobian[:, order], self.rows)
        return bounded(
            self.name,
            measure / self.goal,
            gradient[None] / self.goal,
            low=1.0,
            high=math.inf,
            gain=self.gain,
            speed=self.speed,
        )


@dataclass(frozen=True, eq=False)
class JointCentring:
    """Draw the joints to a reference posture: the descent of eq. (5), n rows.

    H = Σ wᵢ (qᵢ - refᵢ)^p with wᵢ = 1 / range; the value is the posture itself and the error
    -∇H, so that the commanded motion is -gain ∇H in whatever the tasks above leave free. As one
    row on H it would ask for ever more speed where those tasks keep H from falling. It uses all
    that is left: put it last. It only draws: a motion is reached without it, unless there is
    nothing else. Joints without a range are left alone.

    Raises
    ------
    InputError
        If the power is not even (H would fall without end on one side), the reference is not
        finite, or (by `at`) it has not one number per joint.
    """

    power: int = 2
    """Even, at least 2: higher leaves the middle free and pushes harder near the limits."""
    reference: NDArray[np.float64] | None = None
    """Posture to be near to (n,), rad or m; the middle of the ranges when None."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Largest norm of the joint velocities, rad/s."""
    name: str = "joint centring"
    """Name for reports."""
    endless: ClassVar[bool] = True
    """It never ends a motion, see :class:`Task`."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        power = self.power
        if isinstance(power, bool) or not isinstance(power, int) or power < 2 or power % 2:
            raise InputError(
                f"{self.name}: power must be an even whole number >= 2 (eq. 5 has no minimum with "
                f"an odd one), got {power!r}"
            )
        if self.reference is not None:
            store(self, reference=vector(self.name, "reference", self.reference, None))

    def at(self, state: RobotState) -> TaskRows:
        """Value: the posture (n,), rad or m."""
        span = state.upper - state.lower
        ranged = np.isfinite(span) & (span > 0.0)
        weights = np.divide(1.0, span, out=np.zeros_like(span), where=ranged)
        if self.reference is None:
            ends = np.add(state.lower, state.upper, out=2.0 * state.q, where=ranged)
            reference = 0.5 * ends
        elif self.reference.shape != state.q.shape:
            raise InputError(
                f"{self.name}: reference must have one number per joint, {len(state.q)}, got "
                f"{len(self.reference)}"
            )
        else:
            reference = self.reference
        _, gradient = centring_cost(state.q, reference, weights, self.power)
        return TaskRows(self.name, state.q, -gradient, np.eye(len(state.q)), self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class Posture:
    """Go to joint positions, n rows: nothing is left free.

    Raises
    ------
    InputError
        If the goal is not finite, or (by `at`) has not one number per joint.
    """

    goal: NDArray[np.float64]
    """Joint positions (n,), rad or m."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """Largest norm of the joint velocities, rad/s."""
    name: str = "posture"
    """Name for reports."""

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        store(self, goal=vector(self.name, "goal", self.goal, None))

    def at(self, state: RobotState) -> TaskRows:
        """Value: the posture (n,), rad or m."""
        if self.goal.shape != state.q.shape:
            raise InputError(
                f"{self.name}: goal must have one number per joint, {len(state.q)}, got "
                f"{len(self.goal)}"
            )
        jacobian = np.eye(len(state.q))
        return TaskRows(self.name, state.q, self.goal - state.q, jacobian, self.gain, self.speed)


def centring_cost(
    q: NDArray[np.float64],
    reference: NDArray[np.float64],
    weights: NDArray[np.float64],
    power: int,
) -> tuple[float, NDArray[np.float64]]:
    """Cost H of eq. (5) and its gradient (n,), from arrays (n,)."""
    away = q - reference
    slope = weights * away ** (power - 1)
    return float(slope @ away), power * slope


def manipulability(
    jacobian: NDArray[np.float64], rows: tuple[int, ...]
) -> tuple[float, NDArray[np.float64]]:
    """Measure sqrt(det(J Jᵀ)) of chosen rows of a Jacobian (6, n), and its gradient (n,).

    A chain's geometric Jacobian holds its own derivatives: a joint carries the columns of all
    joints after it along, and itself, and the point moves below all joints before it (Bruyninckx
    and De Schutter 1996). Columns are ordered from base to tip; joints that do not move the frame
    have zero columns, and a zero derivative.
    """
    chosen = list(rows)
    u, s, vt = np.linalg.svd(jacobian[chosen], full_matrices=False)
    measure, others = _product(s.tolist())
    slope = np.zeros_like(jacobian)
    slope[chosen] = (u * others) @ vt
    v, w = jacobian[:3], jacobian[3:]
    # Joint k turns column i >= k about wₖ, and moves the point of column i < k by vₖ.
    n = jacobian.shape[1]
    products = _cross(
        np.concatenate([v, w, slope[:3]], axis=1), np.concatenate([slope[:3], slope[3:], w], axis=1)
    )
    carried, moved = products[:, :n] + products[:, n : 2 * n], products[:, 2 * n :]
    reached = carried.cumsum(axis=1)
    after = reached[:, -1:] - reached + carried
    before = moved.cumsum(axis=1) - moved
    return measure, (w * after + v * before).sum(axis=0)


def _product(factors: list[float]) -> tuple[float, list[float]]:
    """Product of all, and of all but each: the slope of a product, without a division by zero."""
    head, tail = [1.0], [1.0]
    for factor in factors:
        head.append(head[-1] * factor)
    for factor in reversed(factors):
        tail.append(tail[-1] * factor)
    return head[-1], [h * t for h, t in zip(head[:-1], reversed(tail[:-1]), strict=True)]


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross products of columns (3, n)."""
    out = np.empty_like(a)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out

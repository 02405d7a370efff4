"""The task that keeps the manipulability of the hand above a bound: one row, in NumPy.

It is not compiled, because the singular value decomposition takes most of its time. A stack with
this task is computed by :mod:`motion_steps`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..robot_state import RobotState
from .inputs import check_gain_and_speed, number, origin, store, vector
from .interval import bounded
from .task import DEFAULT_GAIN, TaskRows

DEFAULT_GROWTH = 1.0
"""Default speed limit of the value, multiples of the goal per second. With the default gain, the
task has no row if the measure is a third or more above the goal."""


@dataclass(frozen=True, eq=False)
class Manipulability:
    """Keep the hand able to move in all directions: sqrt(det(J Jᵀ)) stays above a goal, 1 row.

    The measure is that of Yoshikawa (1985) for selected rows of the Jacobian of a point. The value
    is the measure divided by the goal, so that rows have a similar size on any arm. The goal is a
    lower bound like that of :class:`Interval`: the task has no row well above it. In a singular
    posture the measure has no derivative, and the row is one of the directions that leave the
    singularity. If two directions are singular at once, the row is zero.

    Raises
    ------
    InputError
        If the goal is not positive, a row is not one of 0..5, a number is not finite, or (by `at`)
        there are fewer joints than rows.
    """

    goal: float
    """Lower bound of the measure, in the units of the rows' determinant (m³ for six rows)."""
    rows: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    """Selected rows: 0 to 2 linear x, y, z, 3 to 5 angular, world axes."""
    point: NDArray[np.float64] = field(default_factory=origin)
    """The point (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """Proportional gain, 1/s."""
    speed: float = DEFAULT_GROWTH
    """Speed limit, multiples of the goal per second."""
    name: str = "manipulability"
    """Name for reports."""

    def __post_init__(self) -> None:
        check_gain_and_speed(self.name, self.gain, self.speed)
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
        """Return the row of the measure over the goal, or no row well above the goal."""
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


def manipulability(
    jacobian: NDArray[np.float64], rows: tuple[int, ...]
) -> tuple[float, NDArray[np.float64]]:
    """Return sqrt(det(J Jᵀ)) of selected rows of a Jacobian (6, n), and its gradient (n,).

    The derivatives of a geometric Jacobian are products of its own columns (Bruyninckx and De
    Schutter 1996). A joint rotates its own column and those of all joints after it. It moves the
    point relative to all joints before it. Columns must be ordered from base to tip. A joint that
    does not move the frame has a zero column and a zero derivative.
    """
    selected = list(rows)
    u, s, vt = np.linalg.svd(jacobian[selected], full_matrices=False)
    measure, others = _product(s.tolist())
    slope = np.zeros_like(jacobian)
    slope[selected] = (u * others) @ vt
    v, w = jacobian[:3], jacobian[3:]
    # Joint k rotates column i >= k about wₖ, and moves the point of column i < k by vₖ.
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
    """Return the product of all factors, and for each factor the product of all others."""
    head, tail = [1.0], [1.0]
    for factor in factors:
        head.append(head[-1] * factor)
    for factor in reversed(factors):
        tail.append(tail[-1] * factor)
    return head[-1], [h * t for h, t in zip(head[:-1], reversed(tail[:-1]), strict=True)]


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cross products of columns (3, n)."""
    out = np.empty_like(a)
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out

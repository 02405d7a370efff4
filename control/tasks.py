"""Tasks: what a motion should achieve, as an error and the Jacobian rows that reduce it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Task:
    """One task; its priority is its place in the stack.

    Raises
    ------
    InputError
        If the shapes do not agree or a number is not finite.
    """

    name: str
    """Name for reports."""
    value: NDArray[np.float64]
    """Current value x(q), (m,)."""
    error: NDArray[np.float64]
    """What is left to do, goal minus value, (m,)."""
    jacobian: NDArray[np.float64]
    """Rows J with dx/dt = J dq/dt, (m, n) (eq. 1)."""

    def __post_init__(self) -> None:
        for what in ("value", "error", "jacobian"):
            try:
                array = np.asarray(getattr(self, what), dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError(f"task {self.name}: {what} must be numbers: {error}") from error
            if not np.all(np.isfinite(array)):
                raise InputError(f"task {self.name}: {what} must be finite")
            object.__setattr__(self, what, array)
        rows = len(self.jacobian) if self.jacobian.ndim else 0
        if self.jacobian.ndim != 2 or self.value.shape != (rows,) or self.error.shape != (rows,):
            raise InputError(
                f"task {self.name}: jacobian (m, n), value (m,) and error (m,) must agree, got "
                f"{self.jacobian.shape}, {self.value.shape}, {self.error.shape}"
            )


def position(
    point: NDArray[np.float64], jacobian: NDArray[np.float64], goal: NDArray[np.float64]
) -> Task:
    """Bring a point to a goal: 3 rows.

    Parameters
    ----------
    point, goal
        (3,), m, one frame.
    jacobian
        Linear Jacobian of the point, (3, n).
    """
    return Task("position", point, goal - point, jacobian)


def distance_to_point(
    point: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    centre: NDArray[np.float64],
    distance: float,
) -> Task:
    """Bring a point to a distance from a centre, from any side: 1 row (eq. 4).

    The chapter prints the Jacobian of half the squared distance; with the unit normal instead a
    commanded speed is that speed.

    Raises
    ------
    InputError
        If the point lies on the centre, where no direction leads away.
    """
    offset = point - centre
    length = float(np.linalg.norm(offset))
    if length < 1e-9:
        raise InputError("distance_to_point: the point lies on the centre; start beside it")
    row = (offset / length) @ jacobian
    return Task(
        "distance_to_point", np.array([length]), np.array([distance - length]), row[None, :]
    )


def axis_alignment(
    axis: NDArray[np.float64], jacobian: NDArray[np.float64], goal: NDArray[np.float64]
) -> Task:
    """Turn a unit axis onto a goal direction, the angle about it staying free: 2 rows.

    Parameters
    ----------
    axis, goal
        Directions (3,) of any length, one frame.
    jacobian
        Angular Jacobian of the body that carries the axis, (3, n).

    Raises
    ------
    InputError
        If an axis has no length.
    """
    axis, goal = _unit(axis), _unit(goal)
    turn = np.cross(axis, goal)
    sine = float(np.linalg.norm(turn))
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side = side / np.linalg.norm(side)
    across: NDArray[np.float64] = np.array([side, np.cross(axis, side)], dtype=np.float64)
    # Opposite axes have no shortest turn: any perpendicular one will do.
    direction = turn / sine if sine > 1e-9 else side
    rotation = direction * np.arctan2(sine, float(axis @ goal))
    left = across @ rotation
    return Task("axis_alignment", -left, left, across @ jacobian)


def _unit(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    length = float(np.linalg.norm(direction))
    if not 0.0 < length < float("inf"):
        raise InputError(f"an axis must be finite and not zero, got {direction}")
    return np.asarray(direction, dtype=np.float64) / length

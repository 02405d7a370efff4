"""The state of the robot in one posture: its joints and its controlled frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError


@dataclass(frozen=True, eq=False)
class RobotState:
    """Joints and controlled frame in one posture; n is the number of controlled joints.

    Raises
    ------
    InputError
        If the shapes do not agree, or a joint, the frame or its Jacobian is not finite.
    """

    q: NDArray[np.float64]
    """Joint positions (n,), rad (m for a slide joint)."""
    position: NDArray[np.float64]
    """Origin of the controlled frame (3,), m, world."""
    rotation: NDArray[np.float64]
    """Axes of the controlled frame as columns (3, 3), world."""
    jacobian: NDArray[np.float64]
    """Jacobian of the frame's origin (6, n), rows [v; ω], world axes."""
    lower: NDArray[np.float64]
    """Lower joint limits (n,), -inf where there is none."""
    upper: NDArray[np.float64]
    """Upper joint limits (n,), inf where there is none."""
    home: NDArray[np.float64]
    """Home posture (n,)."""
    speed: NDArray[np.float64]
    """Joint speed limits (n,), rad/s or m/s."""
    acceleration: NDArray[np.float64] | None = None
    """Joint acceleration limits (n,), rad/s² or m/s²; None for none."""
    jerk: NDArray[np.float64] | None = None
    """Joint jerk limits (n,), rad/s³ or m/s³; None for none."""
    from_base: NDArray[np.int64] | None = None
    """Indices (n,) that sort the joints from base to tip; None if they are in that order."""

    def __post_init__(self) -> None:
        n = len(self.q) if self.q.ndim == 1 else -1
        if (
            self.position.shape != (3,)
            or self.rotation.shape != (3, 3)
            or self.jacobian.shape != (6, n)
            or not self.lower.shape == self.upper.shape == self.home.shape == (n,)
            or self.speed.shape != (n,)
        ):
            shapes = {name: np.shape(value) for name, value in vars(self).items()}
            raise InputError(
                "a robot state needs q, lower, upper, home and speed (n,), position (3,), "
                f"rotation (3, 3) and jacobian (6, n), got {shapes}"
            )
        for name in ("q", "position", "rotation", "jacobian"):
            array = getattr(self, name)
            if not math.isfinite(np.vdot(array, array)):
                raise InputError(f"robot state: {name} must be finite, got {array.tolist()}")

    def limits(self, *, instant: bool = False) -> NDArray[np.float64]:
        """Return the limits (n, 5) for kernels: lower, upper, speed, acceleration, jerk.

        Those of acceleration and jerk are infinite if the state has none, or with ``instant``.
        """
        none = np.full(len(self.q), np.inf)
        acceleration = None if instant else self.acceleration
        jerk = None if instant else self.jerk
        return np.column_stack(
            [
                self.lower,
                self.upper,
                self.speed,
                none if acceleration is None else acceleration,
                none if jerk is None else jerk,
            ]
        ).astype(np.float64)

    def point(self, offset: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the position and the Jacobian of a point fixed to the controlled frame.

        Parameters
        ----------
        offset
            The point in the controlled frame (3,), m.

        Returns
        -------
        position, jacobian
            (3,), m, world; its linear Jacobian (3, n), world axes.
        """
        lever = self.rotation @ offset
        return self.position + lever, self.jacobian[:3] - skew(lever) @ self.jacobian[3:]


def skew(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) of the cross product: skew(a) @ b = a × b."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

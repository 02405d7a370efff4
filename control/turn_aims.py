"""Tasks for how the hand is turned: an orientation, a pose, an axis, a look at a target.

The value of each is a pair or triple of angles whose derivative is exactly the Jacobian given:
the logarithm of the rotation, or of the direction, that is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .aim_fields import across, number, rates, rotation, store, transform, unit, vector
from .interval import bounded, released
from .robot_state import skew
from .task import DEFAULT_GAIN, DEFAULT_LINEAR_SPEED, DEFAULT_TURN_SPEED, TaskRows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .robot_state import RobotState

NO_ANGLE = 1e-9
"""Angles below this have no axis, rad: rounding of rotations makes it arbitrary."""
LARGEST_STRETCH = 100.0
"""Limit of angle / sine, by which turning about the goal counts for a nearly opposite axis: it
takes hold within 2° of opposite, and keeps a row that has no limit there from drowning others."""
NEAREST_TARGET = 1e-3
"""Distance below which a look at a target is released, m: there a millimetre turns it around."""


def _origin() -> NDArray[np.float64]:
    return np.zeros(3)


def _forward() -> NDArray[np.float64]:
    return np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Orientation:
    """Turn the controlled frame to a goal: 3 rows.

    The error is the rotation vector, in world axes, of the turn that is left. The value is its
    negative, and the rows are the value's exact derivative: the inverse right Jacobian of the
    rotation group times the angular Jacobian. The commanded turn is about that vector either way,
    as the inverse maps it to itself. At half a turn both ways round are equally short: the one
    taken has its largest coordinate positive.

    Raises
    ------
    InputError
        If the goal is not a rotation, or a number is not finite or out of its range.
    """

    goal: Rotation | NDArray[np.float64]
    """World from frame: a rotation, or its matrix (3, 3)."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """rad/s."""
    name: str = "orientation"
    """Name for reports."""
    _goal: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        store(self, _goal=rotation(self.name, "goal", self.goal))

    def at(self, state: RobotState) -> TaskRows:
        """Value: rotation vector (3,), rad, world axes, from the goal to the frame."""
        error, rows = turn_left(self._goal, state.rotation, state.jacobian[3:])
        return TaskRows(self.name, -error, error, rows, self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class Pose:
    """Bring the controlled frame to a goal: 6 rows, position (m) over orientation (rad).

    Both speeds hold: the whole motion is slowed until neither is passed, so that place and turn
    arrive together.

    Raises
    ------
    InputError
        If the goal is not a pose, or a number is not finite or out of its range.
    """

    goal: RigidTransform | NDArray[np.float64]
    """World from frame: a transform, or its matrix (4, 4)."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The point that is brought to the goal's position (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_LINEAR_SPEED
    """m/s."""
    turn_speed: float = DEFAULT_TURN_SPEED
    """rad/s."""
    name: str = "pose"
    """Name for reports."""
    _position: NDArray[np.float64] = field(init=False, repr=False)
    _rotation: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        rates(self.name, self.gain, self.turn_speed)
        matrix = transform(self.name, "goal", self.goal)
        store(
            self,
            point=vector(self.name, "point", self.point),
            _position=vector(self.name, "goal's position", matrix[:3, 3]),
            _rotation=rotation(self.name, "goal's rotation", matrix[:3, :3]),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the point's position over the rotation vector from the goal, (6,), world."""
        position, linear = state.point(self.point)
        away = self._position - position
        turn, angular = turn_left(self._rotation, state.rotation, state.jacobian[3:])
        error = np.concatenate([away, turn])
        excess = self.gain * max(
            math.sqrt(away @ away) / self.speed, math.sqrt(turn @ turn) / self.turn_speed
        )
        speed = self.gain * math.sqrt(error @ error) / excess if excess > 1.0 else math.inf
        return TaskRows(
            self.name,
            np.concatenate([position, -turn]),
            error,
            np.concatenate([linear, angular]),
            self.gain,
            speed,
        )


@dataclass(frozen=True, eq=False)
class AxisAlignment:
    """Turn an axis of the hand onto a direction, the angle about it staying free: 2 rows.

    The value is the angle between the two, laid off from the goal towards the axis in two fixed
    directions across the goal. Opposite axes have no shortest turn: the one taken is that of the
    two across which the joints turn best.

    Raises
    ------
    InputError
        If a direction has no length, or a number is not finite or out of its range.
    """

    axis: NDArray[np.float64]
    """(3,), in the controlled frame, of any length."""
    goal: NDArray[np.float64]
    """(3,), world, of any length."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """rad/s."""
    name: str = "axis alignment"
    """Name for reports."""
    _across: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        goal = unit(self.name, "goal", self.goal)
        store(self, axis=unit(self.name, "axis", self.axis), goal=goal, _across=across(goal))

    def at(self, state: RobotState) -> TaskRows:
        """Value: (2,), rad; its norm is the angle."""
        axis = state.rotation @ self.axis
        motion = -skew(axis) @ state.jacobian[3:]
        value, rows = direction_rows(axis, motion, self.goal, self._across)
        return TaskRows(self.name, value, -value, rows, self.gain, self.speed)


@dataclass(frozen=True, eq=False)
class LookAt:
    """Keep a target in a cone about an axis of the hand: 2 rows on the axis, else 1 on the angle.

    With a half angle the task is one-sided like :class:`Interval`: released well inside the cone.
    Moving the eye changes the direction to the target as turning does. Nearer to the target than
    a millimetre the direction means nothing, and the task is released.

    Raises
    ------
    InputError
        If a direction has no length, or a number is not finite or out of its range.
    """

    target: NDArray[np.float64]
    """(3,), m, world."""
    half_angle: float = 0.0
    """Largest angle between axis and target, rad, in [0, π]; 0: the axis meets the target."""
    axis: NDArray[np.float64] = field(default_factory=_forward)
    """Where the hand looks (3,), in the controlled frame, of any length."""
    point: NDArray[np.float64] = field(default_factory=_origin)
    """The eye (3,), m, in the controlled frame."""
    gain: float = DEFAULT_GAIN
    """1/s."""
    speed: float = DEFAULT_TURN_SPEED
    """rad/s."""
    name: str = "look at"
    """Name for reports."""
    _across: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rates(self.name, self.gain, self.speed)
        axis = unit(self.name, "axis", self.axis)
        store(
            self,
            target=vector(self.name, "target", self.target),
            half_angle=number(self.name, "half_angle", self.half_angle, low=0.0, high=math.pi),
            axis=axis,
            point=vector(self.name, "point", self.point),
            _across=across(axis),
        )

    def at(self, state: RobotState) -> TaskRows:
        """Value: the target's angles across the axis (2,), rad, or its angle to the axis (1,)."""
        eye, linear = state.point(self.point)
        away = self.target - eye
        distance = math.sqrt(away @ away)
        if distance < NEAREST_TARGET:
            return released(self.name, linear.shape[1])
        # Seen from the hand the axis stands still, and the direction to the target moves.
        look = away / distance
        motion = (np.outer(look, look @ linear) - linear) / distance + skew(look) @ state.jacobian[
            3:
        ]
        look, motion = state.rotation.T @ look, state.rotation.T @ motion
        if self.half_angle == 0.0:
            value, rows = direction_rows(look, motion, self.axis, self._across)
            return TaskRows(self.name, value, -value, rows, self.gain, self.speed)
        angle, row = angle_row(look, motion, self.axis, self._across)
        return bounded(
            self.name,
            angle,
            row[None],
            low=-math.inf,
            high=self.half_angle,
            gain=self.gain,
            speed=self.speed,
        )


def turn_left(
    goal: NDArray[np.float64], turned: NDArray[np.float64], angular: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Turn from a rotation (3, 3) to its goal, and the rows of its negative.

    With e = log(goal turnedᵀ) and the frame's angular Jacobian (3, n), -de/dq = Jr(e)⁻¹ angular,
    Jr⁻¹ = 1 + [e]/2 + (1 - θ/2 cot θ/2)/θ² [e]² (Chirikjian 2012, Stochastic Models 2, 10.86).
    """
    error = _rotation_vector(goal @ turned.T)
    angle = math.sqrt(error @ error)
    # The series' first term is exact to rounding where the closed form loses its digits.
    factor = 1.0 / 12.0 if angle < 1e-3 else (1.0 - angle / 2.0 / math.tan(angle / 2.0)) / angle**2
    cross = skew(error)
    once = cross @ angular
    return error, angular + 0.5 * once + factor * (cross @ once)


def direction_rows(
    direction: NDArray[np.float64],
    motion: NDArray[np.float64],
    pole: NDArray[np.float64],
    basis: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where a unit direction lies about a pole, as angles (2,) along a basis, and their rows.

    Parameters
    ----------
    direction, pole
        Unit vectors (3,).
    motion
        Rows of the direction (3, n), perpendicular to it.
    basis
        Two unit vectors across the pole (2, 3).
    """
    flat, rows, radial, angle, sine = _polar(direction, motion, pole, basis)
    if angle < NO_ANGLE:
        return angle * flat, rows
    stretch = min(angle / sine, LARGEST_STRETCH) if sine > 0.0 else LARGEST_STRETCH
    inward, around = flat, np.array([-flat[1], flat[0]])
    turning = stretch * (around @ rows)
    return angle * inward, inward[:, None] * radial + around[:, None] * turning


def angle_row(
    direction: NDArray[np.float64],
    motion: NDArray[np.float64],
    pole: NDArray[np.float64],
    basis: NDArray[np.float64],
) -> tuple[float, NDArray[np.float64]]:
    """Angle between a unit direction and a pole, and its row (n,); see `direction_rows`."""
    _, _, radial, angle, _ = _polar(direction, motion, pole, basis)
    return angle, radial


def _polar(
    direction: NDArray[np.float64],
    motion: NDArray[np.float64],
    pole: NDArray[np.float64],
    basis: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float, float]:
    """Unit vector from the pole in the basis, rows of the basis, row of the angle, angle, sine."""
    flat = basis @ direction
    rows = basis @ motion
    cosine = float(pole @ direction)
    sine = math.sqrt(flat @ flat)
    if sine < NO_ANGLE:
        # Neither way is shorter: take the one that moves better.
        best = int(rows[1] @ rows[1] > rows[0] @ rows[0])
        flat = np.array([1.0 - best, float(best)])
    else:
        flat = flat / sine
    radial = cosine * (flat @ rows) - sine * (pole @ motion)
    return flat, rows, radial, math.atan2(sine, cosine), sine


def _rotation_vector(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation vector (3,) of a matrix, at any angle up to π (Shepperd 1978)."""
    a, b, c, d, e, f, g, h, i = matrix.ravel().tolist()
    trace = a + e + i
    if trace >= max(a, e, i):
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif a >= max(e, i):
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif e >= i:
        w, x, y, z = c - g, b + d, 1.0 - a + e - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 - a - e + i
    sine = math.sqrt(x * x + y * y + z * z)
    # At half a turn rounding must not choose the way round.
    if w < -NO_ANGLE * sine:
        w, x, y, z = -w, -x, -y, -z
    stretch = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 0.0
    return np.array([x * stretch, y * stretch, z * stretch])

"""The tasks in NumPy: the reference for their kernels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from eyehand.control import RobotState
from eyehand.control.robot_state import skew
from eyehand.control.tasks import (
    AxisAlignment,
    DistanceToAxis,
    DistanceToPoint,
    Interval,
    JointCentring,
    LookAt,
    Orientation,
    PointOnPlane,
    Pose,
    Position,
    Posture,
    Task,
    TaskRows,
)
from eyehand.control.tasks.direction import MAX_STRETCH, MIN_ANGLE
from eyehand.control.tasks.distance import MIN_DISTANCE
from eyehand.control.tasks.inputs import tangents
from eyehand.control.tasks.look_at import MIN_TARGET_DISTANCE
from eyehand.control.tasks.orientation import HALF_TURN_TOLERANCE


def reference(task: Task, state: RobotState) -> TaskRows:
    """Compute the rows of a built-in task."""
    if isinstance(task, Interval):
        rows = reference(task.task, state)
        if len(rows.value) == 0:
            return rows
        return _interval(
            task, rows.value, rows.jacobian, task.low, task.high, rows.gain, rows.speed
        )
    value, error, jacobian, speed = _law(task, state)
    if isinstance(task, LookAt) and len(error) == 1:
        return _interval(task, value, jacobian, -math.inf, task.half_angle, task.gain, task.speed)
    return TaskRows(task.name, value, error, jacobian, task.gain, speed)  # pyright: ignore[reportAttributeAccessIssue] - all have a gain


def _law(task: Task, state: RobotState):
    """Return the value, error, Jacobian and speed limit of a task."""
    match task:
        case Position():
            position, rows = state.point(task.point)
            return position, task.goal - position, rows, task.speed
        case DistanceToPoint():
            position, rows = state.point(task.point)
            value, row = length_row(position - task.centre, rows)
            return np.array([value]), np.array([task.distance - value]), row[None], task.speed
        case DistanceToAxis():
            position, rows = state.point(task.point)
            basis = tangents(task.direction)
            offset, rows = basis @ (position - task.point_on_axis), basis @ rows
            if task.distance == 0.0:
                return offset, -offset, rows, task.speed
            value, row = length_row(offset, rows)
            return np.array([value]), np.array([task.distance - value]), row[None], task.speed
        case PointOnPlane():
            position, rows = state.point(task.point)
            value = np.array([task.normal @ position])
            return value, task.offset - value, (task.normal @ rows)[None], task.speed
        case Orientation():
            error, rows = rotation_error(task._goal, state.rotation, state.jacobian[3:])
            return -error, error, rows, task.speed
        case Pose():
            return _pose(task, state)
        case AxisAlignment():
            axis = state.rotation @ task.axis
            motion = -skew(axis) @ state.jacobian[3:]
            value, rows = direction_rows(axis, motion, task.goal, tangents(task.goal))
            return value, -value, rows, task.speed
        case LookAt():
            return _look_at(task, state)
        case JointCentring():
            return _centring(task, state)
        case Posture():
            return state.q, task.goal - state.q, np.eye(len(state.q)), task.speed
    raise TypeError(f"no reference for {task!r}")


def _pose(task: Pose, state: RobotState):
    position, linear = state.point(task.point)
    offset_to_goal = task._position - position
    turn, angular = rotation_error(task._rotation, state.rotation, state.jacobian[3:])
    error = np.concatenate([offset_to_goal, turn])
    excess = task.gain * max(
        math.sqrt(offset_to_goal @ offset_to_goal) / task.speed,
        math.sqrt(turn @ turn) / task.turn_speed,
    )
    speed = task.gain * math.sqrt(error @ error) / excess if excess > 1.0 else math.inf
    return np.concatenate([position, -turn]), error, np.concatenate([linear, angular]), speed


def _look_at(task: LookAt, state: RobotState):
    eye, linear = state.point(task.point)
    offset_to_goal = task.target - eye
    distance = math.sqrt(offset_to_goal @ offset_to_goal)
    if distance < MIN_TARGET_DISTANCE:
        return np.empty(0), np.empty(0), np.empty((0, linear.shape[1])), task.speed
    view = offset_to_goal / distance
    motion = (np.outer(view, view @ linear) - linear) / distance
    motion = motion + skew(view) @ state.jacobian[3:]
    view, motion = state.rotation.T @ view, state.rotation.T @ motion
    if task.half_angle == 0.0:
        value, rows = direction_rows(view, motion, task.axis, tangents(task.axis))
        return value, -value, rows, task.speed
    angle, row = angle_row(view, motion, task.axis, tangents(task.axis))
    return np.array([angle]), np.zeros(1), row[None], task.speed


def _centring(task: JointCentring, state: RobotState):
    span = state.upper - state.lower
    ranged = np.isfinite(span) & (span > 0.0)
    weights = np.divide(1.0, span, out=np.zeros_like(span), where=ranged)
    middle = 0.5 * np.add(state.lower, state.upper, out=2.0 * state.q, where=ranged)
    goal = middle if task.reference is None else task.reference
    _, gradient = centring_cost(state.q, goal, weights, task.power)
    return state.q, -gradient, np.eye(len(state.q)), task.speed


def _interval(task: Task, value, jacobian, low, high, gain, speed) -> TaskRows:
    x = float(value[0])
    upper = high - x < x - low
    error = (high if upper else low) - x
    inside = error if upper else -error
    if low < high and inside * gain > speed:
        return TaskRows(task.name, np.empty(0), np.empty(0), np.empty((0, jacobian.shape[1])))
    side = 0 if low == high else -1 if upper else 1
    return TaskRows(task.name, value, np.array([error]), jacobian, gain, speed, side)


def centring_cost(
    q: NDArray[np.float64],
    reference: NDArray[np.float64],
    weights: NDArray[np.float64],
    power: int,
) -> tuple[float, NDArray[np.float64]]:
    """Return the cost H of eq. (5) and its gradient (n,), from arrays (n,)."""
    offset = q - reference
    slope = weights * offset ** (power - 1)
    return float(slope @ offset), power * slope


def length_row(
    offset: NDArray[np.float64], rows: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """Return the length of an offset (k,) with rows (k, n), and its derivative (n,).

    At length 0, the derivative is that of the coordinate with the largest row.
    """
    length = math.sqrt(offset @ offset)
    if length < MIN_DISTANCE:
        return length, rows[int(np.argmax(np.einsum("ij,ij->i", rows, rows)))]
    return length, (offset / length) @ rows


def rotation_error(
    goal: NDArray[np.float64], rotation: NDArray[np.float64], angular: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the rotation vector from a rotation (3, 3) to its goal, and the rows of its negative.

    With e = log(goal rotationᵀ) and the frame's angular Jacobian (3, n), -de/dq = Jr(e)⁻¹ angular,
    Jr⁻¹ = 1 + [e]/2 + (1 - θ/2 cot θ/2)/θ² [e]² (Chirikjian 2012, Stochastic Models 2, 10.86).
    """
    error = _rotation_vector(goal @ rotation.T)
    angle = math.sqrt(error @ error)
    # The closed form loses digits at small angles. The first term of the series is exact there.
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
    """Return the polar angles (2,) of a unit direction about a pole, and their rows.

    Parameters
    ----------
    direction, pole
        Unit vectors (3,).
    motion
        Rows of the direction (3, n), perpendicular to it.
    basis
        Two unit vectors perpendicular to the pole (2, 3).
    """
    projected, rows, radial, angle, sine = _polar(direction, motion, pole, basis)
    if angle < MIN_ANGLE:
        return angle * projected, rows
    stretch = min(angle / sine, MAX_STRETCH) if sine > 0.0 else MAX_STRETCH
    inward, around = projected, np.array([-projected[1], projected[0]])
    turning = stretch * (around @ rows)
    return angle * inward, inward[:, None] * radial + around[:, None] * turning


def angle_row(
    direction: NDArray[np.float64],
    motion: NDArray[np.float64],
    pole: NDArray[np.float64],
    basis: NDArray[np.float64],
) -> tuple[float, NDArray[np.float64]]:
    """Return the angle between a unit direction and a pole, and its row (n,)."""
    _, _, radial, angle, _ = _polar(direction, motion, pole, basis)
    return angle, radial


def _polar(
    direction: NDArray[np.float64],
    motion: NDArray[np.float64],
    pole: NDArray[np.float64],
    basis: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float, float]:
    """Return the projected unit vector, its rows, the row of the angle, the angle and its sine."""
    projected = basis @ direction
    rows = basis @ motion
    cosine = float(pole @ direction)
    sine = math.sqrt(projected @ projected)
    if sine < MIN_ANGLE:
        # Both directions are equally long: take the one with the larger row.
        best = int(rows[1] @ rows[1] > rows[0] @ rows[0])
        projected = np.array([1.0 - best, float(best)])
    else:
        projected = projected / sine
    radial = cosine * (projected @ rows) - sine * (pole @ motion)
    return projected, rows, radial, math.atan2(sine, cosine), sine


def _rotation_vector(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation vector (3,) of a matrix, at any angle up to π (Shepperd 1978)."""
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
    # At half a turn, rounding must not decide the direction of rotation.
    if w < -HALF_TURN_TOLERANCE * sine:
        w, x, y, z = -w, -x, -y, -z
    stretch = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 0.0
    return np.array([x * stretch, y * stretch, z * stretch])

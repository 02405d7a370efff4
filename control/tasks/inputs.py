"""Checks of the fields of a task, made once at its construction and not in the control loop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..array_checks import checked_array, read_only

MIN_LENGTH = 1e-12
"""Minimum length of a direction. The direction of a shorter vector is rounding error."""
MAX_DEVIATION = 1e-6
"""Maximum deviation of a matrix from a rotation. It accepts matrices printed with six digits."""


def origin() -> NDArray[np.float64]:
    """Return the default point of a task: the origin of the controlled frame."""
    return np.zeros(3)


def store(task: object, **fields: object) -> None:
    """Set checked fields of a frozen task."""
    for field, value in fields.items():
        object.__setattr__(task, field, value)


def vector(task: str, field: str, value: ArrayLike, size: int | None = 3) -> NDArray[np.float64]:
    """Return a read-only copy of finite numbers (size,); None allows any length.

    Raises
    ------
    InputError
        If a number is not finite, or the shape differs.
    """
    return read_only(checked_array(f"{task}: {field}", value, (size or "n",)))


def unit(task: str, field: str, value: ArrayLike) -> NDArray[np.float64]:
    """Normalise a direction (3,) of any length.

    Raises
    ------
    InputError
        If it is not three finite numbers, or its length is zero.
    """
    direction = vector(task, field, value)
    length = float(np.linalg.norm(direction))
    if length < MIN_LENGTH:
        raise InputError(
            f"{task}: {field} must be a direction with a length above zero, got "
            f"{direction.tolist()}"
        )
    return read_only(direction / length)


def rotation(task: str, field: str, value: Rotation | ArrayLike) -> NDArray[np.float64]:
    """Convert a rotation, or its matrix, to a read-only matrix (3, 3).

    Raises
    ------
    InputError
        If it is not one rotation: orthonormal columns, determinant 1.
    """
    if isinstance(value, Rotation):
        value = value.as_matrix()
    matrix = checked_array(f"{task}: {field}", value, (3, 3))
    deviation = np.abs(matrix.T @ matrix - np.eye(3)).max()
    if deviation > MAX_DEVIATION or np.linalg.det(matrix) < 0.0:
        raise InputError(
            f"{task}: {field} must be a rotation (orthonormal columns, determinant 1), got "
            f"{matrix.tolist()}"
        )
    return read_only(Rotation.from_matrix(matrix).as_matrix())


def transform(task: str, field: str, value: RigidTransform | ArrayLike) -> NDArray[np.float64]:
    """Convert a transform, or its matrix, to a matrix (4, 4); check only its shape.

    Raises
    ------
    InputError
        If it is not one matrix (4, 4) of numbers.
    """
    matrix = value.as_matrix() if isinstance(value, RigidTransform) else value
    return checked_array(f"{task}: {field}", matrix, (4, 4), finite=False)


def number(
    task: str, field: str, value: float, *, low: float = -math.inf, high: float = math.inf
) -> float:
    """Return a finite number in [low, high].

    Raises
    ------
    InputError
        If the value is not a finite number in this range.
    """
    given = _number(task, field, value)
    if not low <= given <= high or math.isinf(given):
        raise InputError(f"{task}: {field} must be finite and in [{low:g}, {high:g}], got {value}")
    return given


def check_gain_and_speed(task: str, gain: float, speed: float) -> None:
    """Check a gain (1/s) and a speed limit (inf: no limit).

    Raises
    ------
    InputError
        If one of them is not positive, or the gain is not finite.
    """
    if not 0.0 < _number(task, "gain", gain) < math.inf:
        raise InputError(f"{task}: gain must be finite and > 0, in 1/s, got {gain}")
    if not _number(task, "speed", speed) > 0.0:
        raise InputError(f"{task}: speed must be > 0 (inf: no limit), got {speed}")


def check_joint_count(task: str, field: str, value: NDArray[np.float64], joints: int) -> None:
    """Check that a vector has one number per joint.

    Raises
    ------
    InputError
        If it has another length.
    """
    if len(value) != joints:
        raise InputError(
            f"{task}: {field} must have one number per joint, {joints}, got {len(value)}"
        )


def tangents(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return two unit vectors (2, 3) perpendicular to a unit direction and to each other."""
    first = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    first /= np.linalg.norm(first)
    return read_only(np.array([first, np.cross(direction, first)], dtype=np.float64))


def _number(task: str, field: str, value: float) -> float:
    try:
        if not isinstance(value, str):
            return float(value)
    except (TypeError, ValueError):
        pass
    raise InputError(f"{task}: {field} must be a number, got {value!r}")

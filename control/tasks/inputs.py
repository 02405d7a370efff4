"""Checks of the fields of a task, made once at its construction and not in the control loop."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

NO_LENGTH = 1e-12
"""Minimum length of a direction. The direction of a shorter vector is rounding error."""
ROUNDED = 1e-6
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
        With the field, its value and what would be right.
    """
    return _numbers(task, field, value, (size,))


def unit(task: str, field: str, value: ArrayLike) -> NDArray[np.float64]:
    """Normalise a direction (3,) of any length.

    Raises
    ------
    InputError
        If it is not three finite numbers, or has no length.
    """
    direction = vector(task, field, value)
    length = float(np.linalg.norm(direction))
    if length < NO_LENGTH:
        raise InputError(
            f"{task}: {field} must be a direction of some length, got {direction.tolist()}"
        )
    direction = direction / length
    direction.flags.writeable = False
    return direction


def rotation(task: str, field: str, value: Rotation | ArrayLike) -> NDArray[np.float64]:
    """Convert a rotation, or its matrix, to a matrix (3, 3).

    Raises
    ------
    InputError
        If it is not one rotation: orthonormal columns, determinant 1.
    """
    if isinstance(value, Rotation):
        value = value.as_matrix()
    matrix = _numbers(task, field, value, (3, 3))
    if np.abs(matrix.T @ matrix - np.eye(3)).max() > ROUNDED or np.linalg.det(matrix) < 0.0:
        raise InputError(
            f"{task}: {field} must be a rotation (orthonormal columns, determinant 1), got "
            f"{matrix.tolist()}"
        )
    matrix = Rotation.from_matrix(matrix).as_matrix()
    matrix.flags.writeable = False
    return matrix


def transform(task: str, field: str, value: RigidTransform | ArrayLike) -> NDArray[np.float64]:
    """Convert a transform, or its matrix, to a matrix (4, 4) without a check of its parts.

    Raises
    ------
    InputError
        If it is not one matrix of numbers.
    """
    given = value.as_matrix() if isinstance(value, RigidTransform) else value
    try:
        matrix = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{task}: {field} must be numbers, got {value!r}") from error
    if matrix.shape != (4, 4):
        raise InputError(
            f"{task}: {field} must be one transform or a matrix (4, 4), got {matrix.shape}"
        )
    return matrix


def number(
    task: str, field: str, value: float, *, low: float = -math.inf, high: float = math.inf
) -> float:
    """Return a finite number in [low, high].

    Raises
    ------
    InputError
        With the field, its value and the range.
    """
    given = _number(task, field, value)
    if not low <= given <= high or math.isinf(given):
        raise InputError(f"{task}: {field} must be finite and in [{low:g}, {high:g}], got {value}")
    return given


def rates(task: str, gain: float, speed: float) -> None:
    """Check a gain (1/s) and a speed (inf: none).

    Raises
    ------
    InputError
        If one of them is not positive, or the gain is not finite.
    """
    if not 0.0 < _number(task, "gain", gain) < math.inf:
        raise InputError(f"{task}: gain must be finite and > 0, in 1/s, got {gain}")
    if not _number(task, "speed", speed) > 0.0:
        raise InputError(f"{task}: speed must be > 0 (inf: no limit), got {speed}")


def across(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit vectors (2, 3) perpendicular to a unit direction and to each other."""
    first = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    first /= np.linalg.norm(first)
    rows: NDArray[np.float64] = np.array([first, np.cross(direction, first)], dtype=np.float64)
    rows.flags.writeable = False
    return rows


def _numbers(
    task: str, field: str, value: object, shape: tuple[int | None, ...]
) -> NDArray[np.float64]:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{task}: {field} must be numbers, got {value!r}") from error
    wanted = "(n,)" if shape == (None,) else str(shape)
    if array.ndim != len(shape) or any(
        size not in (None, got) for size, got in zip(shape, array.shape, strict=True)
    ):
        raise InputError(f"{task}: {field} must have shape {wanted}, got {array.shape}: {value!r}")
    if not np.isfinite(array).all():
        raise InputError(f"{task}: {field} must be finite, got {array.tolist()}")
    array.flags.writeable = False
    return array


def _number(task: str, field: str, value: float) -> float:
    if isinstance(value, str):
        raise InputError(f"{task}: {field} must be a number, got {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{task}: {field} must be a number, got {value!r}") from error


def fits_joints(task: str, field: str, value: NDArray[np.float64], joints: int) -> None:
    """Check that a vector has one number per joint.

    Raises
    ------
    InputError
        If it has not.
    """
    if len(value) != joints:
        raise InputError(
            f"{task}: {field} must have one number per joint, {joints}, got {len(value)}"
        )

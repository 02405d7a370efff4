"""Convert rigid poses from matrices, and from and to JSON."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

ROTATION_TOLERANCE = 1e-3
"""Maximum deviation of a rotation from orthonormal. It covers poses with four digits."""
MAX_DISTANCE_M = 100.0
"""Maximum distance of a pose from the origin, m. No robot cell is that large. A larger distance
means a translation in mm."""


def pose_from_matrix(matrix: NDArray, name: str) -> RigidTransform:
    """Convert a homogeneous matrix (4, 4), m, to a pose.

    The matrix is checked here, because SciPy silently replaces a scaled or mirrored matrix by the
    nearest rotation.

    Parameters
    ----------
    matrix : (4, 4) array
        The homogeneous matrix.
    name : str
        Name of the matrix in error messages.

    Raises
    ------
    InputError
        If the matrix is not a finite (4, 4) matrix, its last row is not 0, 0, 0, 1, its rotation
        is scaled, sheared or mirrored, or its translation is longer than 100 m.
    """
    if matrix.shape != (4, 4) or matrix.dtype.kind not in "fiu":
        raise InputError(
            f"{name} must be a (4, 4) number matrix, got {matrix.shape} {matrix.dtype}"
        )
    matrix = matrix.astype(np.float64)
    if not np.isfinite(matrix).all():
        raise InputError(f"{name} holds NaN or infinite values, expected a finite pose")
    if not np.array_equal(matrix[3], [0.0, 0.0, 0.0, 1.0]):
        raise InputError(f"{name} has last row {matrix[3].tolist()}, expected [0, 0, 0, 1]")
    rotation = matrix[:3, :3]
    error = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if error > ROTATION_TOLERANCE or np.linalg.det(rotation) < 0:
        raise InputError(
            f"{name} does not hold a rotation (R Rᵀ is {error:.3g} from the identity, "
            f"determinant {np.linalg.det(rotation):.3g}, expected 1)"
        )
    _check_distance(matrix[:3, 3], name)
    return RigidTransform.from_matrix(matrix)


def pose_from_json(value: Any, name: str) -> RigidTransform:
    """Read a pose from ``{"quat_wxyz": [w, x, y, z], "translation_m": [x, y, z]}``.

    Four rows of a homogeneous matrix (4, 4), m, are read too.

    Raises
    ------
    InputError
        If the form is different, a value is not a finite number, the quaternion is not of unit
        length, the matrix is no rigid pose, or the translation is longer than 100 m.
    """
    if isinstance(value, list) and len(value) == 4:
        rows = [numbers_from_json(row, 4, f"{name}[{i}]") for i, row in enumerate(value)]
        return pose_from_matrix(np.array(rows), name)
    if not isinstance(value, dict) or not {"quat_wxyz", "translation_m"} <= value.keys():
        raise InputError(
            f'{name} must be {{"quat_wxyz": [w, x, y, z], "translation_m": [x, y, z]}}, or the 4 '
            f"rows of a (4, 4) matrix, got {_shortened(value)}"
        )
    quaternion = numbers_from_json(value["quat_wxyz"], 4, f"{name}.quat_wxyz")
    translation = numbers_from_json(value["translation_m"], 3, f"{name}.translation_m")
    norm = float(np.linalg.norm(quaternion))
    if not abs(norm - 1.0) <= ROTATION_TOLERANCE:
        raise InputError(
            f"{name}.quat_wxyz has length {norm:.4g}, expected 1: got {quaternion.tolist()}, and "
            "no rotation is [1.0, 0.0, 0.0, 0.0]"
        )
    _check_distance(translation, name)
    return RigidTransform.from_components(
        translation, Rotation.from_quat(quaternion, scalar_first=True)
    )


def pose_to_json(pose: RigidTransform) -> dict[str, list[float]]:
    """Return a pose in the form that `pose_from_json` reads."""
    return {
        "quat_wxyz": pose.rotation.as_quat(canonical=True, scalar_first=True).tolist(),
        "translation_m": pose.translation.tolist(),
    }


def _check_distance(translation: NDArray[np.float64], name: str) -> None:
    distance = float(np.linalg.norm(translation))
    if distance > MAX_DISTANCE_M:
        raise InputError(
            f"{name} is {distance:.0f} m from the origin, at most {MAX_DISTANCE_M:g} m is "
            "expected: its translation is probably in mm, write it in m"
        )


def numbers_from_json(value: Any, count: int, name: str) -> NDArray[np.float64]:
    """Check a JSON list of `count` finite numbers and return it, (count,) float64.

    Raises
    ------
    InputError
        If the value is not a list of `count` finite numbers.
    """
    if isinstance(value, list) and len(value) == count and all(map(_is_number, value)):
        try:
            numbers = np.array([float(x) for x in value])
        except OverflowError:
            numbers = np.array([np.inf])
        if np.isfinite(numbers).all():
            return numbers
    raise InputError(f"{name} must be a list of {count} finite numbers, got {_shortened(value)}")


def number_from_json(value: Any, name: str) -> float:
    """Check a finite JSON number and return it as float.

    Raises
    ------
    InputError
        If the value is not a finite number, for example text, true or NaN.
    """
    if not _is_number(value):
        raise InputError(f"{name} must be a number, got {_shortened(value)}")
    # NaN and integers that no float can hold are no finite numbers either.
    if not -sys.float_info.max <= value <= sys.float_info.max:
        raise InputError(f"{name} must be a finite number, got {_shortened(value)}")
    return float(value)


def _is_number(value: Any) -> bool:
    # bool is a subclass of int: true would count as 1.
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _shortened(value: Any, length: int = 80) -> str:
    text = repr(value)
    return text if len(text) <= length else text[: length - 1] + "…"

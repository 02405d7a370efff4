"""Twists of the sensor in the world's frame (eq. 14)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


def adjoint(T_world_sensor: RigidTransform | NDArray[np.float64]) -> NDArray[np.float64]:
    """Give the matrix that turns a sensor twist into the world's spatial twist (eq. 14).

    The linear part of a spatial twist is the velocity of the body's point that is at the world's
    origin just now. Arms are usually told the velocity of the sensor itself: :func:`world_twist`.

    Parameters
    ----------
    T_world_sensor
        Pose of the sensor, a RigidTransform or a matrix (4, 4).

    Returns
    -------
    ndarray
        (6, 6), for twists [v (m/s); ω (rad/s)].

    Raises
    ------
    InputError
        If the pose is not a finite rigid transform.
    """
    R, p = _rotation_and_place(T_world_sensor)
    Ad = np.zeros((6, 6))
    Ad[:3, :3] = R
    Ad[3:, 3:] = R
    Ad[:3, 3:] = _cross_matrix(p) @ R
    return Ad


def world_twist(
    T_world_sensor: RigidTransform | NDArray[np.float64], twist: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give velocity of the sensor's origin and angular velocity, both along the world's axes.

    This is what a Jacobian taken at the sensor's origin maps joint velocities to; it equals
    eq. 14 with the spatial twist moved to the sensor's origin, v + ω x p.

    Parameters
    ----------
    T_world_sensor
        Pose of the sensor, a RigidTransform or a matrix (4, 4).
    twist
        Sensor twist [v; ω] in the sensor's frame, (6,), m/s and rad/s.

    Returns
    -------
    ndarray
        (6,), m/s and rad/s.

    Raises
    ------
    InputError
        If the pose is not a finite rigid transform.
    """
    R, _ = _rotation_and_place(T_world_sensor)
    return np.concatenate([R @ twist[:3], R @ twist[3:]])


def _rotation_and_place(pose: RigidTransform | NDArray[np.float64]):
    matrix = pose.as_matrix() if isinstance(pose, RigidTransform) else np.asarray(pose, float)
    if matrix.shape != (4, 4) or not np.all(np.isfinite(matrix)):
        raise InputError(f"a pose is one finite 4 x 4 matrix, got shape {matrix.shape}")
    R = matrix[:3, :3]
    if not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0:
        raise InputError(f"a pose needs a right-handed rotation, got {R.tolist()}")
    return R, matrix[:3, 3]


def _cross_matrix(p: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y, z = p
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

"""Sensor twists in the world frame, eq. (14)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError


def world_twist(
    T_world_sensor: RigidTransform | NDArray[np.float64], twist: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Transform a sensor twist to the world frame, eq. (14) at the sensor's origin.

    The adjoint matrix of eq. (14) gives the spatial twist. Its linear part v is the velocity of
    the body's point at the world's origin. Here it is v + ω x p, with the sensor's origin p: the
    velocity of the sensor itself. A Jacobian at the sensor's origin maps joint velocities to it.

    Parameters
    ----------
    T_world_sensor
        Pose of the sensor, a RigidTransform or a matrix (4, 4).
    twist
        Sensor twist [v; ω] in the sensor's frame, (6,), m/s and rad/s.

    Returns
    -------
    ndarray
        [v; ω] along the world's axes, (6,), m/s and rad/s.

    Raises
    ------
    InputError
        If the pose is not a finite rigid transform.
    """
    pose = T_world_sensor
    matrix = pose.as_matrix() if isinstance(pose, RigidTransform) else np.asarray(pose, float)
    if matrix.shape != (4, 4) or not np.all(np.isfinite(matrix)):
        raise InputError(f"a pose must be a finite 4 x 4 matrix, got shape {matrix.shape}")
    R = matrix[:3, :3]
    if not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0:
        raise InputError(f"a pose needs a right-handed rotation, got {R.tolist()}")
    return np.concatenate([R @ twist[:3], R @ twist[3:]])

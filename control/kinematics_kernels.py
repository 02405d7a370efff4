"""Forward kinematics and Jacobian of a point that moves with a body, in one compiled call."""

from __future__ import annotations

import numpy as np
from numba import njit

from .mujoco_binding import mj_kinematics


@njit(cache=True)
def set_posture(model, data, q, qpos, qpos_indices):
    """Write joint positions into ``qpos``, and compute all poses with MuJoCo."""
    for column in range(len(qpos_indices)):
        qpos[qpos_indices[column]] = q[column]
    mj_kinematics(model, data)


@njit(cache=True)
def frame_state(model, data, q, qpos, joints, moves, anchors, axes, position, matrix, offset):
    """Return the pose and the Jacobian of a frame at ``q``.

    The arguments are a flat list for the reason given at `cycle_kernels.control_cycle`.

    Parameters
    ----------
    model, data
        Addresses.
    q
        (n,).
    qpos, anchors, axes, position, matrix
        Views of the data: joint positions, ``xanchor`` and ``xaxis`` of all joints, origin (3,)
        and axes (9,) of the frame.
    joints
        (n, 3): index of a controlled joint in ``qpos``, its id, 1 for a hinge and 0 for a slide
        joint.
    moves
        (n,): whether the joint moves the frame.
    offset
        The point in the frame (3,), m.

    Returns
    -------
    point (3,), rotation (3, 3), jacobian (6, n) of the point, rows [v; ω], world axes; copies.
    """
    set_posture(model, data, q, qpos, joints[:, 0])
    point = np.empty(3)
    rotation = np.empty((3, 3))
    for row in range(3):
        point[row] = position[row]
        for column in range(3):
            rotation[row, column] = matrix[3 * row + column]
            point[row] += matrix[3 * row + column] * offset[column]
    jacobian = np.empty((6, len(q)))
    point_jacobian(point, joints[:, 1], joints[:, 2], moves, anchors, axes, jacobian)
    return point, rotation, jacobian


@njit(cache=True)
def point_jacobian(point, joints, hinge, moves, anchors, axes, jacobian):
    """Fill the Jacobian (6, n) of a point (3,), for the poses in the data; see `frame_state`."""
    jacobian[:] = 0.0
    for column in range(len(joints)):
        if not moves[column]:
            continue
        joint = joints[column]
        ax, ay, az = axes[joint, 0], axes[joint, 1], axes[joint, 2]
        if hinge[column]:
            x = point[0] - anchors[joint, 0]
            y = point[1] - anchors[joint, 1]
            z = point[2] - anchors[joint, 2]
            jacobian[0, column] = ay * z - az * y
            jacobian[1, column] = az * x - ax * z
            jacobian[2, column] = ax * y - ay * x
            jacobian[3, column] = ax
            jacobian[4, column] = ay
            jacobian[5, column] = az
        else:
            jacobian[0, column] = ax
            jacobian[1, column] = ay
            jacobian[2, column] = az

"""Inverse kinematics of the start: joint angles that hold the pad at a pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import RobotModel, solve_stack
from eyehand.control.tasks import Pose
from eyehand.errors import InputError

STEPS = 4000
"""Number of cycles after which a pose counts as out of reach, equal to 40 s."""
STEP = 0.01
"""Cycle time, s."""
TOLERANCE = 1e-7
"""Error below which the pose is reached, m and rad."""


def facing_down(position: NDArray[np.float64], heading: float) -> RigidTransform:
    """Return T_world_pad of a pad that faces straight down.

    Parameters
    ----------
    position
        Centre of the pad, (3,), m.
    heading
        Direction of the pad's y-axis, rad, from the world's x-axis about z.
    """
    y = np.array([np.cos(heading), np.sin(heading), 0.0])
    z = np.array([0.0, 0.0, -1.0])
    rotation = Rotation.from_matrix(np.column_stack([np.cross(y, z), y, z]))
    return RigidTransform.from_components(position, rotation)


def start_posture(robot: RobotModel, T_world_pad: RigidTransform) -> NDArray[np.float64]:
    """Return joint angles (n,), rad, that hold the pad at a pose, starting from home.

    Raises
    ------
    InputError
        If the arm does not reach the pose.
    """
    task = Pose(T_world_pad)
    q = np.array(robot.home)
    for _ in range(STEPS):
        rows = task.at(robot.at(q))
        if np.abs(rows.error).max() < TOLERANCE:
            return q
        q = np.clip(q + STEP * solve_stack([rows]).velocity, robot.lower, robot.upper)
    raise InputError(f"the arm does not reach the pad pose {T_world_pad}")

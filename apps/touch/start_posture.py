"""Where an arm's joints must be for its pad to start at a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.control import solve_stack
from eyehand.control.tasks import Pose
from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.control import RobotModel

STEPS = 4000
"""Cycles of motion after which a pose counts as out of reach: 40 s."""
STEP = 0.01
"""Of one, s."""
CLOSE = 1e-7
"""Error at which it is reached, m and rad."""


def looking_down(place: NDArray[np.float64], heading: float) -> RigidTransform:
    """Give T_world_pad of a pad that looks straight down.

    Parameters
    ----------
    place
        Of the pad's middle, (3,), m.
    heading
        Direction of its y-axis, rad from the world's x about z.
    """
    y = np.array([np.cos(heading), np.sin(heading), 0.0])
    z = np.array([0.0, 0.0, -1.0])
    rotation = Rotation.from_matrix(np.column_stack([np.cross(y, z), y, z]))
    return RigidTransform.from_components(place, rotation)


def start_posture(robot: RobotModel, T_world_pad: RigidTransform) -> NDArray[np.float64]:
    """Give joint angles (n,), rad, that hold the pad at a pose, reached from the arm's home.

    Raises
    ------
    InputError
        If the way there does not end at the pose.
    """
    task = Pose(T_world_pad)
    q = np.array(robot.home)
    for _ in range(STEPS):
        rows = task.at(robot.at(q))
        if np.abs(rows.error).max() < CLOSE:
            return q
        q = np.clip(q + STEP * solve_stack([rows]).velocity, robot.lower, robot.upper)
    raise InputError(f"the arm does not reach {T_world_pad.translation} m with its pad turned so")

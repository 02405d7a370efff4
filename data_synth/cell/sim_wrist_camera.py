"""A simulated depth camera on the wrist. It implements the camera protocol."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .grasp_world import ROBOT_PREFIX
from .hand_frame import find_frame

if TYPE_CHECKING:
    from eyehand.perception import DepthFrame

    from .sim_robot import SimRobot

PLACE_M = (0.0, 0.075, -0.06)
"""Position of the camera in the hand's frame: beside the row of fingers and behind the palm. It
looks along the palm's direction. It has no body in the simulation."""
PLACE_ERROR_M, TURN_ERROR_RAD = 5e-4, 2e-3
"""Standard deviations of the hand-eye calibration: 15 noisy images give 0.5 mm and 0.09°."""
_STREAM = 2
"""Number that separates these errors from other random numbers."""


class SimWristCamera:
    """A depth camera on the hand of a simulated robot, with the errors of its calibration.

    Parameters
    ----------
    robot
        The robot that carries it.
    seed
        Seed of the calibration errors.
    """

    def __init__(self, robot: SimRobot, seed: int) -> None:
        self._robot = robot
        self._body, self._site = find_frame(robot.model, ROBOT_PREFIX + robot.hand_frame)
        self.T_palm_camera = RigidTransform.from_translation(PLACE_M)
        """Pose of the camera in the hand's frame."""
        rng = np.random.default_rng([seed, _STREAM])
        self._error = RigidTransform.from_components(
            PLACE_ERROR_M * rng.standard_normal(3),
            Rotation.from_rotvec(TURN_ERROR_RAD * rng.standard_normal(3)),
        )

    def capture(self) -> DepthFrame:
        """Capture a depth image without the robot, as `Robot.capture`."""
        data = self._robot.data
        if self._site < 0:
            origin, axes = data.xpos[self._body], data.xmat[self._body]
        else:
            origin, axes = data.site_xpos[self._site], data.site_xmat[self._site]
        turn = Rotation.from_matrix(axes.reshape(3, 3))
        pose = RigidTransform.from_components(origin, turn) * self.T_palm_camera
        return self._robot.capture_from(pose, pose * self._error)

"""Retreats of a stuck motion: where the arm goes to try again, and how."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .robot_model import RobotModel
from .tasks.task import DEFAULT_LINEAR_SPEED

AT_RETREAT_GOAL = 0.1
"""Maximum norm of the joint differences at which a retreat ends, rad. It need not be exact."""
RETREAT_PATIENCE = 0.3
"""A retreat ends after this time without progress, s."""
RETREAT_SPEED = 1.5
"""Upper limit of the norm of the joint velocities of a retreat, rad/s."""
RETREAT_HAND_SPEED = DEFAULT_LINEAR_SPEED
"""Speed limit of the controlled frame in a retreat, m/s."""
RETREAT_SECONDS = 20.0
"""Time limit of a retreat, s. The motion then tries again from where it is."""


def retreat_configurations(robot: RobotModel) -> tuple[NDArray[np.float64], ...]:
    """Return the configurations (n,) to try again from: home and its mirror image.

    The mirror image bends elbow and wrist the other way, which is often necessary to pass an
    obstacle. A joint is mirrored about the middle of its range, or about zero if it has no range.
    """
    ranged = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    span = np.add(robot.lower, robot.upper, out=np.zeros(robot.n), where=ranged)
    return robot.home, span - robot.home

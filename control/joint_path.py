"""A path of joint positions from a search, and its resampling at constant speed."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .robot_model import RobotModel
from .tasks.task import DEFAULT_LINEAR_SPEED

SPEED_FRACTION = 0.7
"""Fraction of the joint speed limits that a path uses. The rest is needed to catch up."""
MAX_PIECE = 0.05
"""Maximum joint step of a piece of a path whose speed is constant, rad or m."""
ROUNDING = 1e-9
"""Maximum excess over a whole number of cycles that counts as rounding."""


@dataclass(frozen=True)
class JointPath:
    """A path, or the reason why none was found. It is true in a condition if a path was found."""

    found: bool
    """Whether the path ends with all tasks reached."""
    configurations: NDArray[np.float64]
    """Joint positions (N, n) along the path, the start first, rad or m."""
    dt: float
    """Time from one configuration to the next, s."""
    reason: str
    """Why no path was found: what blocked the last roll-out to the goal. Empty otherwise."""
    rollouts: int
    """Number of roll-outs."""
    nodes: int
    """Number of nodes in the tree at the end."""
    seconds: float
    """Time the search took, s."""

    def __bool__(self) -> bool:
        return self.found


def resample_path(
    configurations: NDArray[np.float64], robot: RobotModel, dt: float
) -> NDArray[np.float64]:
    """Resample a path at constant speed: one configuration per cycle, with the first and the last.

    A path consists of several roll-outs, and each slows down towards its end.

    Parameters
    ----------
    configurations
        Joint positions along the path (N, n), rad or m.
    robot
        The robot with its joint speed limits.
    dt
        Control period, s.

    Returns
    -------
    ndarray
        (M, n), linear between the configurations. No step moves the frame faster than the default
        speed of a task, or a joint faster than SPEED_FRACTION of its limit.
    """
    corners = configurations
    pieces = [corners[:1]]
    for start, end in pairwise(corners):
        count = int(np.ceil(np.abs(end - start).max(initial=0.0) / MAX_PIECE)) or 1
        pieces.append(start + np.linspace(0.0, 1.0, count + 1)[1:, None] * (end - start))
    configurations = np.concatenate(pieces)
    positions = np.array([robot.at(q).position for q in configurations])
    by_frame = np.linalg.norm(np.diff(positions, axis=0), axis=1) / DEFAULT_LINEAR_SPEED
    by_joint = np.max(
        np.abs(np.diff(configurations, axis=0)) / (SPEED_FRACTION * robot.speed), axis=1
    )
    times = np.concatenate([[0.0], np.cumsum(np.maximum(by_frame, by_joint))])
    count = int(np.ceil(times[-1] / dt - ROUNDING)) + 1
    samples = np.minimum(dt * np.arange(count), times[-1])
    return np.column_stack([np.interp(samples, times, column) for column in configurations.T])

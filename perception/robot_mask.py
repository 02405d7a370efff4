"""Removal of readings that are known to be no object: the robot itself, a tray, a wall."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .frame import DepthFrame

MARGIN_PX = 3
"""Pixels around the robot's outline that are removed too. Depth there mixes robot and background,
and jitters."""


def mask_robot(
    depth: NDArray[np.float32], robot: NDArray[np.bool_], margin: int = MARGIN_PX
) -> NDArray[np.float32]:
    """Return a depth image (H, W), m, without readings on and near the robot.

    Parameters
    ----------
    depth
        The depth image, (H, W), m.
    robot
        Mask of the robot's pixels, (H, W), for example drawn from its joint angles.
    margin
        Pixels around the mask that are removed too. More pixels forgive a larger error of the
        camera's pose and hide more of the scene.
    """
    if not robot.any():
        return depth
    mask = robot
    if margin > 0:
        mask = ndimage.binary_dilation(robot, iterations=margin, structure=np.ones((3, 3)))
    return np.where(mask, np.float32(0.0), depth)


def mask_points(
    frame: DepthFrame, is_masked: Callable[[NDArray[np.float64]], NDArray[np.bool_]]
) -> NDArray[np.float32]:
    """Return a frame's depth image (H, W), m, without readings in given parts of the world.

    Parameters
    ----------
    frame
        The frame. Without `T_world_camera` nothing is removed.
    is_masked
        Function from points (N, 3), m, world frame, to a mask (N,) of those to remove.
    """
    depth = frame.depth
    measured = depth > 0
    if frame.T_world_camera is None or not measured.any():
        return depth
    points = frame.intrinsics.rays()[measured] * depth[measured, None]
    kept = depth.copy()
    masked = is_masked(frame.T_world_camera.apply(points))
    kept[measured] = np.where(masked, np.float32(0.0), depth[measured])
    return kept

"""Take out of a depth image what a robot knows not to be an object: itself, and its own tray."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from eyehand.perception.frame import DepthFrame

MARGIN_PX = 3
"""Pixels beside the robot's outline that are taken with it: there depth is mixed and jittered."""


def mask_robot(
    depth: NDArray[np.float32], robot: NDArray[np.bool_], margin: int = MARGIN_PX
) -> NDArray[np.float32]:
    """Give a depth image (H, W), m, with no reading on and near the robot's pixels.

    Parameters
    ----------
    depth
        The image, (H, W), m.
    robot
        Where the robot's own kinematics put it, (H, W).
    margin
        How many pixels beside it are taken too: more forgives a camera that stands not quite where
        it is said to, and costs sight.
    """
    if not robot.any():
        return depth
    if margin > 0:
        grown = ndimage.binary_dilation(robot, iterations=margin, structure=np.ones((3, 3)))
        return np.where(grown, np.float32(0.0), depth)
    return np.where(robot, np.float32(0.0), depth)


def mask_points(
    frame: DepthFrame, taken: Callable[[NDArray[np.float64]], NDArray[np.bool_]]
) -> NDArray[np.float32]:
    """Give the depth image (H, W), m, of a frame without readings of certain places.

    Parameters
    ----------
    frame
        With `T_world_camera`.
    taken
        Tells of points (N, 3), world, m, which of them to leave out, (N,).
    """
    depth = frame.depth
    seen = depth > 0
    T_world_camera = frame.T_world_camera
    if T_world_camera is None or not seen.any():
        return depth
    points = frame.intrinsics.rays()[seen] * depth[seen, None]
    keep = depth.copy()
    keep[seen] = np.where(taken(T_world_camera.apply(points)), np.float32(0.0), depth[seen])
    return keep

"""Fuse depth images of a static scene into one with fewer holes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from eyehand.perception import DepthFrame


def fuse_frames(frames: Sequence[DepthFrame]) -> DepthFrame:
    """Fuse depth images by the median of the valid readings of each pixel.

    A pixel is a hole only if no image has a reading there. For an even number of readings the
    nearer of the two middle ones is used, because their mean could lie between an object and its
    background.

    Parameters
    ----------
    frames
        At least one frame, the oldest first, all with the same intrinsics. A frame
        whose camera pose differs from that of the newest frame is ignored.

    Returns
    -------
    DepthFrame
        The newest frame (its colour and pose) with the fused depth.
    """
    newest = frames[-1]
    stack = np.stack([frame.depth for frame in frames if _same_pose(frame, newest)])
    if len(stack) == 1:
        return newest
    valid = stack > 0.0
    ranked = np.sort(np.where(valid, stack, np.inf), axis=0)
    middle = np.maximum(valid.sum(axis=0) - 1, 0) // 2
    depth = np.take_along_axis(ranked, middle[None], axis=0)[0]
    depth = np.where(np.isfinite(depth), depth, 0.0)
    return replace(newest, depth=depth.astype(newest.depth.dtype))


def _same_pose(frame: DepthFrame, newest: DepthFrame) -> bool:
    pose, newest_pose = frame.T_world_camera, newest.T_world_camera
    if pose is None or newest_pose is None:
        return pose is newest_pose
    return bool(np.array_equal(pose.as_matrix(), newest_pose.as_matrix()))

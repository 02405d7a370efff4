"""The image that the stages work on: reduced, smoothed, as depth and as disparity."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

    from ..frame import CameraIntrinsics, DepthFrame


class View(NamedTuple):
    """One depth frame as the stages see it; 0 = no reading."""

    depth: NDArray[np.float32]
    """(H, W), m."""
    disparity: NDArray[np.float32]
    """(H, W), 1/m."""
    intrinsics: CameraIntrinsics
    """Camera of this image."""
    T_world_camera: RigidTransform | None
    """Place of the camera, where it is known."""
    colour: NDArray[np.uint8] | None
    """(H, W, 3) RGB, where there is colour."""


def view_of(frame: DepthFrame, stride: int, *, median: bool) -> View:
    """Take every `stride`-th row and column, with a 3x3 median over disparity or without."""
    # A copy: kernels compile once more for the frame's read-only array.
    depth = frame.depth[::stride, ::stride].copy()
    disparity = inverse(depth)
    if median:
        smooth = cv2.medianBlur(disparity, 3)
        # Where a reading has too few neighbours it stays as it is; none is made up.
        disparity = np.where((disparity > 0) & (smooth > 0), smooth, disparity)
        depth = inverse(disparity)
    colour = None if frame.colour is None else frame.colour[::stride, ::stride]
    camera = frame.intrinsics.reduced(stride)
    return View(depth, disparity, camera, frame.T_world_camera, colour)


def inverse(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth to disparity or back, 0 stays 0."""
    return np.divide(1.0, image, out=np.zeros_like(image), where=image > 0)

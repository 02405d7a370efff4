"""Check the intrinsics of a camera by images of a calibration board."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from ..frame import CameraIntrinsics
from .calibration_board import BoardView

MIN_CONTRADICTION, MIN_DOUBT = 0.02, 0.005
"""Differences of a focal length, in focal lengths, and of the principal point, in image sizes, from
which intrinsics are wrong, and doubtful. Those of depth cameras are right to 0.5 %."""
SIGMAS = 4.0
"""Difference in its standard deviations from which the images contradict the intrinsics."""


def contradicted_intrinsics(
    views: Sequence[BoardView], camera: CameraIntrinsics
) -> tuple[str, bool]:
    """Return how the images contradict the intrinsics, and whether these are certainly wrong.

    The text is empty if they do not.

    The method of Zhang ("A flexible new technique for camera calibration", 2000) estimates focal
    lengths and principal point from the images alone. It needs tilted views: otherwise the standard
    deviations are too large for a contradiction.

    Parameters
    ----------
    views
        The board in each image, at least 4 without those that are empty.
    camera
        The intrinsics that were given, of images without distortion.
    """
    size = (camera.width, camera.height)
    rigid = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    try:
        _, matrix, _, _, _, sigmas, *_ = cv2.calibrateCameraExtended(
            [view.points.astype(np.float32) for view in views],
            [view.pixels.astype(np.float32) for view in views],
            size,
            camera.matrix,
            np.zeros(5),
            flags=cv2.CALIB_USE_INTRINSIC_GUESS | rigid,
        )
    except cv2.error:
        return "", False
    given = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    found = matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    share = abs(found - given) / np.array([camera.fx, camera.fy, *size])
    share[abs(found - given) < SIGMAS * sigmas.ravel()[:4]] = 0.0
    if share.max() < MIN_DOUBT:
        return "", False
    values = [", ".join(f"{value:.0f}" for value in k) for k in (found, given)]
    return (
        f"the images of the board show fx, fy, cx, cy = {values[0]} px, and the camera file says "
        f"{values[1]}: write the intrinsics of these images, which must be without distortion"
    ), bool(share.max() >= MIN_CONTRADICTION)

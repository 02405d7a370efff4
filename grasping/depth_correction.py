"""Correct the scale and the tilt of a depth image from the known height of the support."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import DepthFrame, SupportPlane, find_support

MAX_SCALE = 0.15
"""Maximum correction of the scale. A larger one is a wrong height or another surface."""
LIKELY_SCALE = 0.03
"""Correction that sensors need: the noise model `dex` has 3.2 % (one standard deviation)."""
DOUBTFUL_SCALE = 2.0 * LIKELY_SCALE
"""Correction beyond which no grasp is safe."""
MAX_TILT = np.radians(5.0)
"""Maximum correction of the tilt, rad."""
MIN_TILT = np.radians(0.1)
"""Smaller tilts are within the noise of the plane, rad."""
MIN_HEIGHT = 0.05
"""Minimum height of the camera above the support, m. A lower one does not determine the scale."""

CORRECTED_SCALE_ERROR = 0.005
"""Standard deviation of the scale that remains after the correction, a share of the distance."""


@dataclass(frozen=True)
class DepthCorrection:
    """The correction of a depth image. False if it was refused; the frame is then unchanged."""

    scale: float
    """Factor of all depths; 1 if refused."""
    height_error: float
    """Height of the support in the image before the correction minus the known one, m."""
    tilt: float
    """Angle between the support in the image and the horizontal, rad. It is corrected too."""
    reason: str = ""
    """Why the correction was refused."""

    def __bool__(self) -> bool:
        return not self.reason

    @property
    def warning(self) -> str:
        """A doubt about the known height or the pose of the camera; empty without one."""
        change = self.scale - 1.0
        if abs(change) <= LIKELY_SCALE:
            return ""
        return (
            f"the scale of the depth changed by {100 * change:+.1f} %, more than the "
            f"{100 * LIKELY_SCALE:.0f} % that sensors need: check the height of the table and the "
            "pose of the camera"
        )

    @property
    def doubtful(self) -> bool:
        """Whether the correction is so large that no grasp should be executed."""
        return abs(self.scale - 1.0) > DOUBTFUL_SCALE


def correct_depth(
    frame: DepthFrame, support_height: float, support: SupportPlane | None = None
) -> tuple[DepthFrame, DepthCorrection]:
    """Scale a depth image so that its support plane lies at a known height, and level it.

    The scale is the ratio of the camera's true height above the support to the measured one. The
    remaining tilt is removed by a rotation of the camera's pose about the camera's position. A tilt
    below 0.1° is left as it is.

    Parameters
    ----------
    frame
        The depth frame; `T_world_camera` must be known.
    support_height
        Height of the support in the world, m.
    support
        The support plane of the frame, camera frame, if it is known; None finds it.

    Returns
    -------
    frame, correction
        The corrected frame with its `scale_error`, or the same frame if `correction` is false:
        there is no support, or the correction exceeds 15 % or 5°.

    Raises
    ------
    InputError
        If the pose of the camera is unknown, or the height is no finite number below the camera.
    """
    T_world_camera = frame.T_world_camera
    if T_world_camera is None:
        raise InputError("the correction of the depth needs T_world_camera")
    if not isinstance(support_height, (int, float, np.number)):
        raise InputError(f"the support's height must be a number, m, got {support_height!r}")
    true_height = float(T_world_camera.translation[2]) - support_height
    if not np.isfinite(support_height) or true_height < MIN_HEIGHT:
        raise InputError(
            f"the support's height must be finite and at least {MIN_HEIGHT} m below the camera "
            f"at {T_world_camera.translation[2]:.3f} m; got {support_height} m"
        )
    support = support or find_support(frame)
    if support is None:
        return frame, DepthCorrection(1.0, 0.0, 0.0, "the image shows no support")
    normal = T_world_camera.rotation.apply(support.normal)
    # The plane's offset in the camera frame is the camera's distance from it.
    scale = true_height / support.offset
    tilt = float(np.arccos(np.clip(normal[2], -1.0, 1.0)))
    correction = DepthCorrection(scale, true_height - support.offset, tilt)
    if abs(scale - 1.0) > MAX_SCALE:
        reason = f"the scale would change by {100 * (scale - 1):+.0f} %, at most 15 % is allowed"
        return frame, replace(correction, scale=1.0, reason=reason)
    if tilt > MAX_TILT:
        reason = f"the support is tilted by {np.degrees(tilt):.1f}°, at most 5° is allowed"
        return frame, replace(correction, scale=1.0, reason=reason)
    pose = _levelled(T_world_camera, normal)
    depth = (frame.depth * np.float32(scale)).astype(np.float32)
    error = min(frame.scale_error, CORRECTED_SCALE_ERROR)
    return replace(frame, depth=depth, T_world_camera=pose, scale_error=error), correction


def _levelled(T_world_camera: RigidTransform, normal: NDArray[np.float64]) -> RigidTransform:
    """Return the camera's pose rotated about its position until the normal is vertical."""
    axis = np.cross(normal, [0.0, 0.0, 1.0])
    sine = float(np.linalg.norm(axis))
    if sine < np.sin(MIN_TILT):
        return T_world_camera
    turn = Rotation.from_rotvec(axis / sine * np.arcsin(sine))
    return RigidTransform.from_components(
        T_world_camera.translation, turn * T_world_camera.rotation
    )

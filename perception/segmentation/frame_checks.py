"""Check whether a frame shows a scene, and whether its camera can be right."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import RigidTransform

from ..frame import CameraIntrinsics, DepthFrame
from .frame_noise import NoiseProfile
from .options import SegmentationOptions
from .result import SupportPlane
from .scene_warnings import SceneWarning
from .support_plane import MAX_TILT, find_supports
from .working_image import WorkingImage

FIELD_OF_VIEW_DEG = (5.0, 150.0)
"""Range of the field of view of depth cameras, with room for crops of their images, °."""
FAR_M, FAR_QUANTILE = 2.5, 0.05
"""Distance beyond which no solid is fitted, m, and the share of the readings that may be nearer. A
frame beyond it is usually in another unit: a D405 counts 0.1 mm."""
NEAR_M, NEAR_QUANTILE = 0.1, 0.25
"""Distance within which few depth cameras measure, m, and the share of the readings that must be
nearer. It is that of 24 real frames in mm that are read in 0.1 mm. Fingers take up less."""
CHECK_UNIT = (
    "Check the unit of the depth (`depth_scale_mm` of the camera file, mm per unit of a PNG; 1 if "
    "it is missing)"
)
MAX_CAMERA_M = 20.0
"""Maximum distance of a camera from the origin of the world, m. Robot cells are smaller."""
MAX_LEVEL_TILT = math.radians(3.0)
"""Maximum angle between a level table and the horizontal plane of the world, rad. The normal of the
table is estimated to 0.5°. A larger angle usually means a wrong camera pose, with errors of
centimetres on the table."""
MAX_ASPECT = 1.2
"""Maximum ratio of the focal lengths, either way. Pixels of depth cameras are square within 2 %."""
SCALED_SIZES = ((0.5, 70.0, 180.0), (2.0, 0.0, 55.0))
"""Sizes of the image that wrong intrinsics belong to, in sizes of this image, and the field of view
that they then have here, °. Depth cameras have 45 to 90°; a part of an image has less."""
CENTRE_SHARE = 0.03
"""Maximum distance of the principal point of such an image from its middle, in image sizes."""
EXCHANGED_SHIFT = 0.06
"""Distance of the principal point from the middle, in image sizes, from which its coordinates are
exchanged if it is in the middle with cx as cy. Real cameras have at most 0.02."""
MAX_CENTRE_SHIFT = 0.23
"""Maximum distance of the principal point from the middle, in image sizes. Whole images of 19 real
cameras have at most 0.02; half the intrinsics have 0.25. A crop may have more."""
STEP = 7
"""Distance of the pixels whose spread is measured, px. It leaves thousands of them."""
MIN_READINGS = 50
"""Minimum number of these pixels with readings. Fewer show neither noise nor a constant image."""
SPREAD_QUANTILES = (0.16, 0.84)
"""Quantiles of disparity whose distance is twice the spread: ±1 σ of a normal distribution."""
NOISE_OF_SPREAD = 0.5
"""Minimum noise of a frame of noise, in spreads. It is 0.02 on real frames, and 0.7 to 1.2 on
images of noise."""
NOISE_OF_DEPTH = 0.01
"""Minimum noise of a frame of noise, as a share of depth. A flat wall also has noise and no spread.
Real frames have at most 0.0024 after the median filter."""


def check_frame(frame: DepthFrame, image: WorkingImage) -> tuple[SceneWarning, ...]:
    """Return warnings about a frame that shows no scene, or whose camera is implausible.

    Parameters
    ----------
    frame
        The frame.
    image
        Its working image, with the measured noise.
    """
    faults = list(frame_faults(frame))
    sample = image.disparity[::STEP, ::STEP]
    sample = sample[sample > 0]
    if sample.size < MIN_READINGS:
        return tuple(faults)
    low, middle, high = np.quantile(sample, (SPREAD_QUANTILES[0], 0.5, SPREAD_QUANTILES[1]))
    noise = image.noise
    smooth = noise <= max(NOISE_OF_SPREAD * (high - low) / 2, NOISE_OF_DEPTH * middle)
    if not smooth and all(fault.kind != "constant" for fault in faults):
        share = f"{100 * noise / middle:.0f} %"
        message = f"the readings are noise of {share} of depth: no surface is smooth"
        faults.append(SceneWarning("noise", message))
    if np.quantile(sample, 1.0 - FAR_QUANTILE) < 1.0 / FAR_M:
        message = (
            f"nearly all readings are beyond {FAR_M:g} m, the median at {1 / middle:.1f} m: no "
            f"solid is fitted there. {CHECK_UNIT}"
        )
        faults.append(SceneWarning("far", message))
    elif np.quantile(sample, 1.0 - NEAR_QUANTILE) > 1.0 / NEAR_M:
        message = (
            f"many readings are nearer than {NEAR_M:g} m, the median at {1 / middle:.2f} m: few "
            f"cameras measure there. {CHECK_UNIT}"
        )
        faults.append(SceneWarning("near", message))
    return tuple(faults)


def frame_faults(frame: DepthFrame) -> tuple[SceneWarning, ...]:
    """Return the warnings that need no segmentation: camera, distance of the pose, constant image.

    Parameters
    ----------
    frame
        The frame.
    """
    faults = []
    if message := _camera_fault(frame.intrinsics):
        faults.append(SceneWarning("camera", message))
    elif message := _centre_fault(frame.intrinsics):
        faults.append(SceneWarning("principal_point", message))
    pose = frame.T_world_camera
    distance = 0.0 if pose is None else float(np.linalg.norm(pose.translation))
    if distance > MAX_CAMERA_M:
        message = (
            f"T_world_camera places the camera {distance:.0f} m from the origin of the world, "
            f"expected at most {MAX_CAMERA_M:g} m: the translation must be in m"
        )
        faults.append(SceneWarning("pose", message))
    sample = frame.depth[::STEP, ::STEP]
    sample = sample[sample > 0]
    if (
        sample.size >= MIN_READINGS
        and np.ptp(sample) == 0
        and np.ptp(frame.depth[frame.valid]) == 0
    ):
        message = (
            f"all readings are {sample[0]:.3f} m: the camera is broken, or sees a bare table from "
            "straight above without any noise"
        )
        faults.append(SceneWarning("constant", message))
    return tuple(faults)


def check_pose(
    image: WorkingImage, options: SegmentationOptions, noise: NoiseProfile
) -> tuple[SceneWarning, ...]:
    """Return a warning if the best plane of an image without a support is steep in the world."""
    if image.T_world_camera is None:
        return ()
    planes = find_supports(image._replace(T_world_camera=None), options, noise)
    if not planes:
        return ()
    tilt = _tilt(planes[0].plane, image.T_world_camera)
    if tilt <= MAX_TILT:
        return ()
    message = (
        f"with T_world_camera the best plane is tilted by {math.degrees(tilt):.0f}°. If it is the "
        "table, the pose is wrong. It must map the optical frame (x right, y down, z forward) to "
        "the world (z up), and may be inverted"
    )
    return (SceneWarning("pose", message),)


def check_tilt(
    support: SupportPlane, T_world_camera: RigidTransform | None
) -> tuple[SceneWarning, ...]:
    """Return a warning if the support is not level in the world.

    Parameters
    ----------
    support
        The support, camera frame.
    T_world_camera
        Pose of the camera; None if it is unknown.
    """
    if T_world_camera is None:
        return ()
    tilt = _tilt(support, T_world_camera)
    if tilt <= MAX_LEVEL_TILT:
        return ()
    message = (
        f"the support is tilted by {math.degrees(tilt):.1f}° in the world. If the table is level, "
        "the rotation of T_world_camera is wrong, and so are all positions in the world"
    )
    return (SceneWarning("support_tilted", message),)


def _tilt(plane: SupportPlane, T_world_camera: RigidTransform) -> float:
    """Return the angle between a plane in the camera frame and the horizontal plane, rad."""
    up = float(T_world_camera.as_matrix()[2, :3] @ plane.normal)
    return math.acos(min(max(up, -1.0), 1.0))


def _camera_fault(camera: CameraIntrinsics) -> str:
    """Return why the intrinsics are implausible; empty if they are not."""
    size = f"{camera.width} x {camera.height} px"
    if not (0 < camera.cx < camera.width and 0 < camera.cy < camera.height):
        where = f"({camera.cx:g}, {camera.cy:g})"
        return f"the principal point {where} px is not inside the image of {size}"
    angle = math.degrees(2 * math.atan(camera.width / (2 * camera.fx)))
    low, high = FIELD_OF_VIEW_DEG
    if not low <= angle <= high:
        return (
            f"the field of view is {angle:.1f}° at fx = {camera.fx:g} px and {size}, expected "
            f"{low:g} to {high:g}°"
        )
    if max(camera.fx / camera.fy, camera.fy / camera.fx) > MAX_ASPECT:
        return f"the focal lengths fx = {camera.fx:g} px and fy = {camera.fy:g} px differ too much"
    for scale, least, most in SCALED_SIZES:
        near = _shift(camera.cx / scale, camera.cy / scale, camera) < CENTRE_SHARE
        if near and least < angle < most:
            return (
                f"fx = {camera.fx:g} px and the principal point ({camera.cx:g}, {camera.cy:g}) px "
                f"belong to an image {scale:g} times as large, not to {size}"
            )
    if (
        _shift(camera.cx, camera.cy, camera) > EXCHANGED_SHIFT
        and _shift(camera.cy, camera.cx, camera) < CENTRE_SHARE
    ):
        return (
            f"the principal point ({camera.cx:g}, {camera.cy:g}) px is the middle of the image of "
            f"{size} if cx and cy are exchanged"
        )
    return ""


def _shift(x: float, y: float, camera: CameraIntrinsics) -> float:
    """Return the distance of a principal point (x, y), px, from the middle, in image sizes."""
    return max(abs(x / camera.width - 0.5), abs(y / camera.height - 0.5))


def _centre_fault(camera: CameraIntrinsics) -> str:
    """Return why the principal point is doubtful; empty if it is near the middle of the image."""
    if _shift(camera.cx, camera.cy, camera) <= MAX_CENTRE_SHIFT:
        return ""
    return (
        f"the principal point ({camera.cx:g}, {camera.cy:g}) px is far from the middle of the "
        f"image of {camera.width} x {camera.height} px. Unless the image is a crop, the intrinsics "
        "belong to another resolution, and all positions are wrong"
    )

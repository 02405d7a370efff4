"""Hand-eye calibration: the pose of a camera from images of a board and poses of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..frame import CameraIntrinsics
from .calibration_board import BoardView
from .hand_eye_bundle import MIN_SIGMAS, Bundle

CameraMount = Literal["world", "wrist"]
"""What the camera is fixed to. The board is fixed to the other one."""
MIN_IMAGES = 4
"""Minimum number of usable images. Three determine the pose, a fourth checks it."""
MIN_SPREAD = np.deg2rad(5.0)
"""Minimum spread of the axes of rotation, rad. Below it the poses turn about one axis only."""
OUTLIER_SIGMAS = 4.0
"""A robot pose that needs a larger correction, in median corrections, is left out."""


@dataclass(frozen=True)
class HandEyeOptions:
    """Options of :func:`calibrate_hand_eye`."""

    camera_on: CameraMount = "world"
    """What the camera is fixed to. With ``world`` the wrist carries the board."""


# Arrays have no truth value: equality is identity.
@dataclass(frozen=True, eq=False)
class HandEye:
    """The result of a calibration. It is false if the images do not determine the pose."""

    camera: RigidTransform | None
    """T_world_camera, or T_wrist_camera of a camera on the wrist."""
    board: RigidTransform | None
    """T_wrist_board, or T_world_board of a camera on the wrist."""
    position_error: float
    """Standard deviation of the camera's position, all axes together, m."""
    angle_error: float
    """Standard deviation of the camera's orientation, all axes together, rad."""
    pixel_error: float
    """Standard deviation of a corner, px."""
    pose_errors: NDArray[np.float64]
    """Correction that each robot pose needs to explain its image, (N, 2): m and rad. NaN where no
    board was found."""
    left_out: tuple[int, ...]
    """Numbers of the images that contradict the others."""
    reason: str
    """Why there is no pose; empty if there is one."""

    def __bool__(self) -> bool:
        return self.camera is not None


def calibrate_hand_eye(
    views: Sequence[BoardView],
    wrist_poses: Sequence[RigidTransform],
    camera: CameraIntrinsics,
    options: HandEyeOptions | None = None,
) -> HandEye:
    """Estimate where a camera is mounted, from images of a board at several poses of the robot.

    The closed form of Park and Martin starts a bundle adjustment. Its unknowns are the poses of
    camera and board, and a small correction of every robot pose. The errors of corners and of
    robot poses are estimated from the residuals, so that the stated error includes the accuracy of
    the robot.

    Parameters
    ----------
    views
        The board in each image; views that are false are skipped.
    wrist_poses
        T_world_wrist of each image.
    camera
        Intrinsics of images without distortion.
    options
        Where the camera is mounted.

    Raises
    ------
    InputError
        If the numbers of views and poses differ.
    """
    options = options or HandEyeOptions()
    if len(views) != len(wrist_poses):
        raise InputError(f"{len(views)} images have {len(wrist_poses)} poses, expected one each")
    count = len(views)
    found = {i: board_pose(view, camera) for i, view in enumerate(views) if view}
    seen = {i: pose for i, pose in found.items() if pose is not None}
    if len(seen) < MIN_IMAGES:
        return _failed(
            count,
            f"the board is visible in {len(seen)} of {count} images, at least {MIN_IMAGES} needed",
        )
    used = list(seen)
    spread = axis_spread([wrist_poses[i] for i in used])
    if spread < MIN_SPREAD:
        return _failed(
            count,
            f"the wrist turns about one axis only (spread {np.rad2deg(spread):.1f}°, at least "
            f"{np.rad2deg(MIN_SPREAD):.0f}° needed): tilt it about a second axis by 20° or more",
        )
    inverse = [seen[i].inv() for i in used]
    if options.camera_on == "wrist":
        start = closed_form([wrist_poses[i] for i in used], [seen[i] for i in used])
        board = wrist_poses[used[0]] * start * seen[used[0]]
    else:
        board = closed_form([wrist_poses[i] for i in used], inverse)
        start = wrist_poses[used[0]] * board * inverse[0]
    bundle = Bundle(
        views, RigidTransform.concatenate(list(wrist_poses)), camera, options.camera_on == "wrist"
    )
    solved = bundle.solve(used, start, board)
    left_out: list[int] = []
    while len(used) > max(MIN_IMAGES, 3 * len(seen) // 4):
        size = solved.corrections / np.maximum(
            np.median(solved.corrections, axis=0), MIN_SIGMAS[1:]
        )
        worst = int(size.max(axis=1).argmax())
        if size[worst].max() <= OUTLIER_SIGMAS:
            break
        left_out.append(used.pop(worst))
        solved = bundle.solve(used, solved.camera, solved.board)
    errors = np.full((count, 2), np.nan)
    errors[used] = solved.corrections
    return HandEye(
        camera=solved.camera,
        board=solved.board,
        position_error=solved.position_error,
        angle_error=solved.angle_error,
        pixel_error=solved.sigmas[0],
        pose_errors=errors,
        left_out=tuple(sorted(left_out)),
        reason="",
    )


def _failed(count: int, reason: str) -> HandEye:
    nothing = np.full((count, 2), np.nan)
    return HandEye(None, None, np.inf, np.inf, np.nan, nothing, (), reason)


def board_pose(view: BoardView, camera: CameraIntrinsics) -> RigidTransform | None:
    """Return T_camera_board of one view, or None if no pose explains the corners."""
    matrix = np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])
    try:
        found, turn, shift = cv2.solvePnP(
            view.points, view.pixels, matrix, np.zeros(5), flags=cv2.SOLVEPNP_IPPE
        )
    except cv2.error:
        return None
    shift = np.asarray(shift, np.float64).reshape(3)
    if not found or not np.isfinite(shift).all() or shift[2] <= 0:
        return None
    rotation = Rotation.from_rotvec(np.asarray(turn, np.float64).reshape(3))
    return RigidTransform.from_components(shift, rotation)


def axis_spread(poses: Sequence[RigidTransform]) -> float:
    """Return how far poses turn about a second axis, rad.

    It is the second singular value of the rotation vectors between all pairs, divided by the root
    of their number. It is 0 if all turn about one axis. Then no calibration is determined.
    """
    turns = [(a.inv() * b).rotation.as_rotvec() for a, b in combinations(poses, 2)]
    return float(np.linalg.svd(np.array(turns), compute_uv=False)[1] / np.sqrt(len(turns)))


def closed_form(moved: Sequence[RigidTransform], seen: Sequence[RigidTransform]) -> RigidTransform:
    """Solve A X = X B for the motions between all pairs of poses.

    Park and Martin, "Robot sensor calibration: solving AX = XB on the Euclidean group", IEEE
    Trans. Robotics and Automation 10(5), 1994: first the rotation, then the translation.

    Parameters
    ----------
    moved
        Poses of the frame that carries the unknown one, T_fixed_carrier, one per image.
    seen
        Poses of the fixed object in the unknown frame, one per image.

    Returns
    -------
    RigidTransform
        The unknown pose T_carrier_unknown.
    """
    first, second = [], []
    for i, k in combinations(range(len(moved)), 2):
        first.append(moved[i].inv() * moved[k])
        second.append(seen[i] * seen[k].inv())
    turns_a = np.array([motion.rotation.as_rotvec() for motion in first])
    turns_b = np.array([motion.rotation.as_rotvec() for motion in second])
    rotation = Rotation.align_vectors(turns_a, turns_b)[0]
    rows = np.vstack([motion.rotation.as_matrix() - np.eye(3) for motion in first])
    values = np.concatenate(
        [rotation.apply(b.translation) - a.translation for a, b in zip(first, second, strict=True)]
    )
    shift: NDArray[np.float64] = np.linalg.lstsq(rows, values, rcond=None)[0]
    return RigidTransform.from_components(shift, rotation)

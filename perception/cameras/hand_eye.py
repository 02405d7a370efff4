"""Hand-eye calibration: the pose of a camera from images of a board and poses of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError

from ..frame import CameraIntrinsics
from .board_intrinsics import contradicted_intrinsics
from .calibration_board import BoardView
from .hand_eye_bundle import MIN_SIGMAS, Bundle, BundleResult

CameraMount = Literal["world", "wrist"]
"""What the camera is fixed to. The board is fixed to the other one."""
MIN_IMAGES = 4
"""Minimum number of usable images. Three determine the pose, a fourth checks it."""
MIN_SPREAD = np.deg2rad(5.0)
"""Minimum spread of the axes of rotation, rad. Below it the poses turn about one axis only."""
OUTLIER_SIGMAS = 4.0
"""A robot pose that needs a larger correction, in median corrections, is left out."""
MAX_PIXEL_ERROR = 1.0
"""Maximum standard deviation of a corner, px. Good images give 0.2 px."""
MAX_POSE_ERROR = (5e-3, np.deg2rad(0.5))
"""Maximum median correction of the robot poses, m and rad. A robot with errors of 0.5 mm and 0.06°
along each axis gives 0.7 mm and 0.1°."""
FITTING_TURN = np.deg2rad(0.1)
"""Median correction of the orientations below which they are right, and only positions are wrong,
rad."""
MAX_POSITION = 10.0
"""Maximum distance of the wrist from the world's origin, m. A larger number is probably in mm."""
MAX_SCALE_ERROR = 0.02
"""Standard deviation of the board's scale above which the images do not check the board's size."""
WRONG_SCALE, WRONG_SCALE_SIGMAS = 0.01, 3.0
"""A scale that differs from 1 by more than both contradicts the given size of the board."""


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
    """Standard deviation of the camera's position, all axes together, m. It holds for a board of
    exactly the given size."""
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
    board_scale: float = 1.0
    """Size of the board that explains the images best, divided by its given size."""
    board_scale_error: float = np.inf
    """Standard deviation of `board_scale`."""
    wrong_size: bool = False
    """Whether there is no pose because `board_scale` contradicts the given size of the board."""
    warning: str = ""
    """What the images leave unchecked; empty if nothing."""

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

    A second adjustment estimates the size of the board too. The result is false if it contradicts
    the given size, or if the images do not fit the robot poses or contradict the intrinsics.

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
        If the numbers of views and poses differ, or a wrist is implausibly far away.
    """
    options = options or HandEyeOptions()
    count = len(views)
    _check_poses(wrist_poses, count)
    found = {i: board_pose(view, camera) for i, view in enumerate(views) if view}
    seen = {i: pose for i, pose in found.items() if pose is not None}
    if len(seen) < MIN_IMAGES:
        return _failed(
            count,
            f"the board is visible in {len(seen)} of {count} images, at least {MIN_IMAGES} "
            "needed: check the number and order of the squares, and the dictionary",
        )
    used = list(seen)
    spread = axis_spread([wrist_poses[i] for i in used])
    if spread < MIN_SPREAD:
        return _failed(
            count,
            f"the wrist turns about one axis only (spread {np.rad2deg(spread):.1f}°, at least "
            f"{np.rad2deg(MIN_SPREAD):.0f}° needed): tilt it about a second axis by 20° or more",
        )
    doubt, wrong = contradicted_intrinsics([views[i] for i in used], camera)
    if wrong:
        return _failed(count, doubt)
    start, board = _start(wrist_poses, seen, options.camera_on)
    bundle = Bundle(
        views, RigidTransform.concatenate(list(wrist_poses)), camera, options.camera_on == "wrist"
    )
    solved = bundle.solve(used, start, board)
    solved, used = _without_outliers(bundle, solved, used)
    errors = np.full((count, 2), np.nan)
    errors[used] = solved.corrections
    # A wrong size of the board leaves small residuals: the robot poses absorb it.
    scaled = solved
    if solved.sigmas[0] <= MAX_PIXEL_ERROR:
        scaled = bundle.solve(used, solved.camera, solved.board, free_scale=True)
    result = HandEye(
        camera=solved.camera,
        board=solved.board,
        position_error=solved.position_error,
        angle_error=solved.angle_error,
        pixel_error=solved.sigmas[0],
        pose_errors=errors,
        left_out=tuple(sorted(seen.keys() - set(used))),
        reason="",
        board_scale=scaled.scale,
        board_scale_error=scaled.scale_error,
        warning=doubt,
    )
    least = max(WRONG_SCALE, WRONG_SCALE_SIGMAS * scaled.scale_error)
    if abs(scaled.scale - 1.0) > least and _fits(scaled):
        reason = f"the board seems to be {scaled.scale:.3f} times as large as given"
        return replace(result, camera=None, board=None, reason=reason, wrong_size=True)
    if not _fits(solved):
        reason = _misfit(solved) + _better_hypothesis(views, wrist_poses, seen, camera, options)
        return replace(result, camera=None, board=None, reason=reason)
    if scaled.scale_error > MAX_SCALE_ERROR:
        warning = (
            "the images do not check the size of the board, because its distance varies too "
            "little: measure the squares, or vary the distance by a third"
        )
        return replace(result, warning="; ".join(filter(None, (doubt, warning))))
    return result


def _check_poses(wrist_poses: Sequence[RigidTransform], count: int) -> None:
    """Refuse another number of poses than of images, and poses far away."""
    if count != len(wrist_poses):
        raise InputError(f"{count} images have {len(wrist_poses)} poses, expected one each")
    for pose in wrist_poses:
        if (distance := float(np.linalg.norm(pose.translation))) > MAX_POSITION:
            raise InputError(
                f"a robot pose is {distance:.0f} m from the origin, at most {MAX_POSITION:.0f} m "
                "expected: is it in mm? Then give metres"
            )


def _without_outliers(
    bundle: Bundle, solved: BundleResult, used: list[int]
) -> tuple[BundleResult, list[int]]:
    """Drop the image that contradicts the others most, as long as one does and enough remain."""
    enough, used = max(MIN_IMAGES, 3 * len(used) // 4), list(used)
    while len(used) > enough:
        size = solved.corrections / np.maximum(
            np.median(solved.corrections, axis=0), MIN_SIGMAS[1:]
        )
        worst = int(size.max(axis=1).argmax())
        if size[worst].max() <= OUTLIER_SIGMAS:
            break
        used.pop(worst)
        solved = bundle.solve(used, solved.camera, solved.board)
    return solved, used


def _start(
    wrist_poses: Sequence[RigidTransform], seen: dict[int, RigidTransform], mount: CameraMount
) -> tuple[RigidTransform, RigidTransform]:
    """Return the poses of camera and board in closed form."""
    moved = [wrist_poses[i] for i in seen]
    first = next(iter(seen.values()))
    if mount == "wrist":
        camera = closed_form(moved, list(seen.values()))
        return camera, moved[0] * camera * first
    board = closed_form(moved, [pose.inv() for pose in seen.values()])
    return moved[0] * board * first.inv(), board


def _fits(solved: BundleResult) -> bool:
    """Report whether the images agree with the robot poses."""
    errors = np.median(solved.corrections, axis=0)
    return bool(solved.sigmas[0] <= MAX_PIXEL_ERROR and (errors <= MAX_POSE_ERROR).all())


def _misfit(solved: BundleResult) -> str:
    shift, turn = np.median(solved.corrections, axis=0)
    hint = (
        "the order of the quaternion (w, x, y, z), the direction of the poses (wrist in the "
        "world), --camera-on, and the sizes of the board"
    )
    if solved.sigmas[0] <= MAX_PIXEL_ERROR and turn < FITTING_TURN:
        hint = "the positions of the robot and the time of the images: the orientations fit"
    return (
        f"the images do not fit the robot poses: residual {solved.sigmas[0]:.2f} px, median pose "
        f"error {1e3 * shift:.1f} mm and {np.rad2deg(turn):.2f}°, at most {MAX_PIXEL_ERROR:g} px, "
        f"{1e3 * MAX_POSE_ERROR[0]:g} mm and {np.rad2deg(MAX_POSE_ERROR[1]):g}° expected. "
        f"Check {hint}"
    )


def _better_hypothesis(
    views: Sequence[BoardView],
    wrist_poses: Sequence[RigidTransform],
    seen: dict[int, RigidTransform],
    camera: CameraIntrinsics,
    options: HandEyeOptions,
) -> str:
    """Return a sentence on the usual mistake that explains the images, or nothing.

    A camera in the world with inverted poses has the same equations as one on the wrist. The two
    cannot be distinguished.
    """
    other: CameraMount = "wrist" if options.camera_on == "world" else "world"
    order = "quaternions in the order x, y, z, w"
    mount = f"--camera-on {other}, or with inverted poses"
    reordered = [_reordered(pose) for pose in wrist_poses]
    hypotheses: list[tuple[Sequence[RigidTransform], CameraMount, str]] = [
        (wrist_poses, other, mount),
        (reordered, options.camera_on, order),
        (reordered, other, f"{order} and {mount}"),
    ]
    for poses, on, words in hypotheses:
        bundle = Bundle(views, RigidTransform.concatenate(list(poses)), camera, on == "wrist")
        if _fits(bundle.solve(list(seen), *_start(poses, seen, on))):
            return f". They fit with {words}"
    return ""


def _reordered(pose: RigidTransform) -> RigidTransform:
    """Return a pose whose quaternion x, y, z, w was read as w, x, y, z."""
    values = pose.rotation.as_quat(scalar_first=True)
    return RigidTransform.from_components(pose.translation, Rotation.from_quat(values))


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

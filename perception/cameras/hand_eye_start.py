"""The closed-form start of a hand-eye calibration, and the pose of a board in one image."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from ..frame import CameraIntrinsics
from .calibration_board import BoardView


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

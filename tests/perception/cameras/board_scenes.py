"""Poses of a robot, a camera and a calibration board, and images of the board."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import CameraIntrinsics
from eyehand.perception.cameras import BoardView, CalibrationBoard, CameraMount

CAMERA = CameraIntrinsics(600.0, 600.0, 319.5, 239.5, 640, 480)


@dataclass(frozen=True)
class BoardScene:
    """True poses of one calibration."""

    camera: RigidTransform
    """T_world_camera, or T_wrist_camera of a camera on the wrist."""
    wrist: list[RigidTransform]
    """T_world_wrist of each image."""
    seen: list[RigidTransform]
    """T_camera_board of each image."""


def board_scene(mount: CameraMount, count: int, seed: int, tilt: float = 0.5) -> BoardScene:
    """Return `count` poses that turn the board by up to `tilt` rad about each axis."""
    rng = np.random.default_rng(seed)
    wrist_camera = _pose([0.03, -0.05, 0.07], [5.0, 10.0, 90.0])
    camera = _pose([1.0, 0.0, 0.8], [-130.0, 0.0, 90.0])
    board = _pose([0.02, 0.0, 0.1], [0.0, 0.0, 30.0])
    seen = [
        RigidTransform.from_components(
            rng.uniform([-0.05, -0.04, 0.4], [0.05, 0.04, 0.55]),
            Rotation.from_rotvec(rng.uniform(-tilt, tilt, 3)),
        )
        * RigidTransform.from_translation([-0.105, -0.08, 0.0])  # turn about the board's middle
        for _ in range(count)
    ]
    if mount == "wrist":
        fixed = _pose([0.5, 0.0, 0.0], [180.0, 0.0, 0.0])
        wrist = [fixed * one.inv() * wrist_camera.inv() for one in seen]
        return BoardScene(wrist_camera, wrist, seen)
    return BoardScene(camera, [camera * one * board.inv() for one in seen], seen)


def exact_views(scene: BoardScene, board: CalibrationBoard) -> list[BoardView]:
    """Return the views of a scene without errors."""
    return [BoardView(project(one.apply(board.corners)), board.corners) for one in scene.seen]


def project(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the pixels (N, 2) of points (N, 3) in the camera frame."""
    x, y, z = points.T
    return np.column_stack([CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy])


def moved(pose: RigidTransform, rng: np.random.Generator, shift: float, turn: float):
    """Return a pose with normal errors of `shift` m and `turn` rad along each axis."""
    error = Rotation.from_rotvec(rng.normal(0.0, turn, 3))
    return pose * RigidTransform.from_components(rng.normal(0.0, shift, 3), error)


def board_image(pose: RigidTransform, board: CalibrationBoard) -> NDArray[np.uint8]:
    """Render a board at T_camera_board in front of a grey wall, with blur and noise."""
    per_square, margin = 60, 40
    drawn = board.image(per_square, margin)
    corners = np.array([[0, 0], [board.columns, 0], [board.columns, board.rows], [0, board.rows]])
    points = np.column_stack([corners * board.square, np.zeros(4)])
    # The centre of the drawing's first pixel lies half a pixel inside the board.
    source = corners * per_square + margin - 0.5
    scale = 4
    target = (project(pose.apply(points)) + 0.5) * scale - 0.5
    warp = cv2.getPerspectiveTransform(source.astype(np.float32), target.astype(np.float32))
    size = (CAMERA.width * scale, CAMERA.height * scale)
    large = cv2.warpPerspective(drawn, warp, size, flags=cv2.INTER_LINEAR, borderValue=(110,))
    image = cv2.resize(large, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA)
    noisy = image + np.random.default_rng(0).normal(0.0, 2.0, image.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def _pose(translation: list[float], degrees: list[float]) -> RigidTransform:
    return RigidTransform.from_components(
        translation, Rotation.from_euler("xyz", degrees, degrees=True)
    )

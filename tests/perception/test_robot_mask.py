"""Tests of masking robot and world regions in the depth image."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception.frame import CameraIntrinsics, DepthFrame
from eyehand.perception.robot_mask import mask_points, mask_robot

DEPTH = np.ones((20, 30), dtype=np.float32)


def test_robot_and_margin_have_no_reading():
    robot = np.zeros(DEPTH.shape, dtype=bool)
    robot[10, 15] = True
    masked = mask_robot(DEPTH, robot, margin=2)
    assert (masked[8:13, 13:18] == 0).all()
    assert (masked == 0).sum() == 25
    assert (mask_robot(DEPTH, robot, margin=0) == 0).sum() == 1


def test_image_without_robot_is_returned_unchanged():
    assert mask_robot(DEPTH, np.zeros(DEPTH.shape, dtype=bool)) is DEPTH


def test_world_points_are_masked():
    camera = CameraIntrinsics(30.0, 30.0, 14.5, 9.5, 30, 20)
    frame = DepthFrame(DEPTH, camera, RigidTransform.from_translation([1.0, 0.0, 0.0]))
    masked = mask_points(frame, lambda points: points[:, 0] > 1.0)
    assert (masked[:, 15:] == 0).all()
    assert (masked[:, :15] == 1).all()

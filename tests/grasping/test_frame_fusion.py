"""Fusion of depth images from one camera pose."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from eyehand.grasping.frame_fusion import fuse_frames
from eyehand.perception import CameraIntrinsics, DepthFrame

LENS = CameraIntrinsics(50.0, 50.0, 1.5, 0.5, 4, 2)
POSE = RigidTransform.from_translation([0.0, 0.0, 1.0])


def frame(*depth: float, pose: RigidTransform | None = POSE) -> DepthFrame:
    return DepthFrame(np.array([depth, np.ones(4)], np.float32), LENS, pose)


def test_pixel_is_median_of_its_readings():
    fused = fuse_frames(
        [frame(1.0, 1.0, 0.0, 0.0), frame(1.2, 0.0, 0.0, 0.9), frame(1.1, 2.0, 0.0, 0.0)]
    )
    np.testing.assert_array_equal(fused.depth[0], np.array([1.1, 1.0, 0.0, 0.9], np.float32))
    assert fused.depth.dtype == np.float32
    assert fused.T_world_camera is POSE


@given(st.lists(st.lists(st.sampled_from([0.0, 0.7, 1.3]), min_size=4, max_size=4), min_size=1))
def test_pixel_is_empty_only_if_no_image_has_reading(rows):
    fused = fuse_frames([frame(*row) for row in rows]).depth[0]
    stack = np.array(rows, np.float32)
    np.testing.assert_array_equal(fused == 0.0, (stack == 0.0).all(axis=0))
    assert all(value in stack[:, k] for k, value in enumerate(fused))


@pytest.mark.parametrize("pose", [None, RigidTransform.from_translation([0.0, 0.0, 1.1])])
def test_images_from_other_camera_poses_are_ignored(pose):
    newest = frame(1.0, 0.0, 1.0, 1.0)
    fused = fuse_frames([frame(2.0, 2.0, 2.0, 2.0, pose=pose), newest])
    np.testing.assert_array_equal(fused.depth, newest.depth)
    assert fuse_frames([replace(newest)]).depth[0, 1] == 0.0

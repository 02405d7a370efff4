"""Tests of masking robot and world regions in the depth image."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception.frame import CameraIntrinsics, DepthFrame
from eyehand.perception.robot_mask import (
    DIRECTIONS,
    MARGIN_M,
    MARGIN_SLOPE,
    PosedVolumes,
    mark_volumes,
    mask_points,
    mask_robot,
    mask_volumes,
    volume_extents,
)

SMALL = DepthFrame(
    np.ones((20, 30), dtype=np.float32), CameraIntrinsics(30.0, 30.0, 14.5, 9.5, 30, 20)
)
CAMERA = CameraIntrinsics(60.0, 62.0, 39.5, 29.5, 80, 60)
CUBE = np.array(list(product((-0.1, 0.1), repeat=3)))


def volumes(*poses: RigidTransform) -> PosedVolumes:
    """Return cubes of 0.2 m at poses."""
    matrices = np.array([pose.as_matrix() for pose in poses]).reshape(-1, 4, 4)
    return PosedVolumes(volume_extents([CUBE] * len(poses)), matrices)


def test_robot_and_margin_have_no_reading():
    robot = np.zeros(SMALL.depth.shape, dtype=bool)
    robot[10, 15] = True
    masked = mask_robot(SMALL, robot, margin=2)
    assert (masked.depth[8:13, 13:18] == 0).all()
    assert (masked.depth == 0).sum() == 25
    np.testing.assert_array_equal(masked.masked, masked.depth == 0)
    assert (mask_robot(SMALL, robot, margin=0).depth == 0).sum() == 1


def test_frame_without_robot_is_returned_unchanged():
    assert mask_robot(SMALL, np.zeros(SMALL.depth.shape, dtype=bool)) is SMALL


def test_masks_add_up_and_the_last_reading_cannot_be_masked():
    left, right = np.zeros((2, *SMALL.depth.shape), dtype=bool)
    left[:, :15], right[:, 15:] = True, True
    assert SMALL.masked is None
    half = SMALL.without(left)
    np.testing.assert_array_equal(half.without(left[::-1]).masked, left)
    with pytest.raises(InputError, match="the masks leave no reading"):
        half.without(right)
    with pytest.raises(InputError, match=r"must have shape \(20, 30\), got \(2, 2\)"):
        SMALL.without(left[:2, :2])
    with pytest.raises(InputError, match=r"masked must be \(20, 30\) bool"):
        replace(SMALL, masked=left[:2])


def test_world_points_are_masked():
    frame = replace(SMALL, T_world_camera=RigidTransform.from_translation([1.0, 0.0, 0.0]))
    masked = mask_points(frame, lambda points: points[:, 0] > 1.0)
    assert (masked.depth[:, 15:] == 0).all()
    assert (masked.depth[:, :15] == 1).all()


@pytest.mark.parametrize("seed", range(4))
def test_kernel_equals_the_test_of_every_reading(seed):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 2.0, (60, 80)).astype(np.float32) * (rng.random((60, 80)) > 0.2)
    normals = rng.normal(size=(3, 26, 3))
    offsets = rng.uniform(0.5, 3.0, (3, 26))
    boxes = np.tile(np.array([0, 60, 0, 80]), (3, 1))
    found = np.zeros(depth.shape, np.bool_)
    mark_volumes(depth, (60.0, 62.0, 39.5, 29.5), (normals, offsets, boxes), (0.1, 0.2), found)
    points = CAMERA.rays() * depth[..., None]
    along = np.einsum("nki,vui->vunk", normals, points)
    grown = offsets + (0.1 + 0.2 * depth)[..., None, None]
    expected = (along <= grown).all(axis=3).any(axis=2) & (depth > 0)
    assert 0 < expected.sum() < depth.size
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("posed", [False, True])
def test_readings_in_a_volume_are_masked_and_those_before_and_behind_it_stay(posed):
    turn = RigidTransform.from_rotation(Rotation.from_rotvec([0.3, 0.5, 0.2]))
    T_camera_cube = RigidTransform.from_translation([0.0, 0.0, 1.0]) * turn
    T_world_camera = RigidTransform.from_components(
        [0.5, -0.2, 0.9], Rotation.from_rotvec([2.0, 0.4, 0.1])
    )
    pose = T_world_camera * T_camera_cube if posed else T_camera_cube
    depth = np.full((60, 80), 3.0, np.float32)
    depth[20:40, 30:50] = 1.0
    depth[20:40, 30:38] = 0.5
    frame = DepthFrame(depth, CAMERA, T_world_camera if posed else None)
    kept = mask_volumes(frame, volumes(pose)).depth
    assert kept[30, 40] == 0
    assert kept[30, 31] == np.float32(0.5)
    assert (kept[:15] == 3).all()
    points = T_camera_cube.inv().apply((CAMERA.rays() * depth[..., None]).reshape(-1, 3))
    margin = MARGIN_M + MARGIN_SLOPE * depth.ravel()
    inside = (np.abs(points).max(axis=1) < 0.1 + margin).reshape(depth.shape)
    assert inside.any()
    assert (kept[inside] == 0).mean() > 0.95


def test_volume_behind_the_lens_and_one_around_it_are_handled():
    depth = np.full((60, 80), 0.05, np.float32)
    depth[:8, :8] = 3.0
    frame = DepthFrame(depth, CAMERA)
    behind = volumes(RigidTransform.from_translation([0.0, 0.0, -1.0]))
    assert mask_volumes(frame, behind) is frame
    around = mask_volumes(frame, volumes(RigidTransform.identity())).depth
    assert (around[10:, 10:] == 0).all()
    assert around[0, 0] == 3.0


def test_hull_is_within_its_extents_and_they_are_tight_for_a_box():
    points = np.random.default_rng(0).normal(size=(50, 3))
    extents = volume_extents([points, CUBE])
    assert extents.shape == (2, 26)
    assert (points @ DIRECTIONS.T <= extents[0] + 1e-12).all()
    faces = np.abs(DIRECTIONS).max(axis=1) == 1.0
    np.testing.assert_allclose(extents[1][faces], 0.1)


def test_invalid_volumes_are_rejected():
    with pytest.raises(InputError, match=r"poses \(N, 4, 4\)"):
        PosedVolumes(np.ones((2, 26)), np.tile(np.eye(4), (3, 1, 1)))
    with pytest.raises(InputError, match="finite"):
        PosedVolumes(np.full((1, 26), np.nan), np.eye(4)[None])

"""Readings that belong to no object: a board beside a thing counts, the table and edges do not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage
from synthetic_solids import T_TABLE_CAMERA, Box, Plate, solid_frame

from eyehand.perception import CameraIntrinsics, segment
from eyehand.perception.background_points import (
    ALIKE,
    EDGE,
    MAX_POINTS,
    MIN_ALIKE,
    MIN_ALIKE_FRONT,
    MIN_HEIGHT,
    THIN_WEIGHT,
    background_points,
    free_readings,
)

CAMERA = CameraIntrinsics(520.0, 520.0, 319.5, 239.5, 640, 480)
THING, BOARD = Box(0.0, 0.7, (0.07, 0.07, 0.09)), Box(0.12, 0.75, (0.03, 0.1, 0.2))
FAR = Box(-0.45, 0.8, (0.1, 0.1, 0.1))


def test_unlabelled_thing_near_an_object_is_background():
    frame, truth = solid_frame([THING, BOARD, FAR], (Plate(),), CAMERA, known_pose=True)
    assert frame.T_world_camera is not None
    found = replace(segment(frame), labels=(truth == 1).astype(np.int32))
    cloud = frame.T_world_camera.apply(frame.points()[truth == 1].astype(np.float64))
    points = background_points(frame, found, frame.T_world_camera, [cloud])
    camera = frame.T_world_camera.inv().apply(points)
    at = T_TABLE_CAMERA.apply(camera)
    assert 300 < len(points) <= MAX_POINTS
    assert at[:, 2].min() > MIN_HEIGHT - 0.001
    half = 0.5 * np.array(BOARD.size) + 0.002
    assert (np.abs(at[:, :2] - [BOARD.x, BOARD.y]) < half[:2]).all()
    assert at[:, 2].max() > BOARD.size[2] - 0.02


@pytest.mark.parametrize("width", [0.0025, 0.004])
def test_thin_post_is_background_but_a_column_of_mixed_readings_is_not(width):
    post = Box(0.1, 0.72, (width, width, 0.14))
    frame, truth = solid_frame([THING, post], (Plate(),), CAMERA, known_pose=True)
    world = frame.T_world_camera
    assert world is not None
    depth = frame.depth.copy()
    depth[100:300, 110:120], depth[100:300, 120] = 0.5, 0.56
    frame = replace(frame, depth=depth)
    found = replace(segment(frame), labels=(truth == 1).astype(np.int32))
    cloud = world.apply(frame.points()[truth == 1].astype(np.float64))
    camera = world.inv().apply(background_points(frame, found, world, [cloud]))
    near = np.abs(camera[:, 2] - 0.5) < 0.001
    assert near.any()
    assert len(np.unique(camera, axis=0)) < len(camera), "a thin thing counts more"
    assert (np.abs(camera[:, 2] - 0.56) > 0.01).all()
    at = T_TABLE_CAMERA.apply(camera[~near])
    assert len(at) > 20
    assert (np.abs(at[:, :2] - [post.x, post.y]) < 0.006).all()


def test_nothing_is_background_without_a_support_or_objects():
    frame, truth = solid_frame([THING, BOARD], (Plate(),), CAMERA, known_pose=True)
    assert frame.T_world_camera is not None
    found = replace(segment(frame), labels=np.zeros(truth.shape, np.int32))
    assert background_points(frame, found, frame.T_world_camera, []).shape == (0, 3)
    cloud = np.zeros((1, 3))
    none = replace(found, support=None)
    assert background_points(frame, none, frame.T_world_camera, [cloud]).shape == (0, 3)


def weights_with_numpy(depth):
    """Return how often each reading of an image counts."""
    padded = np.pad(depth, 1)
    shifts = [(dv, du) for dv in (0, 1, 2) for du in (0, 1, 2) if (dv, du) != (1, 1)]
    rows, columns = depth.shape
    around = np.array([padded[dv : dv + rows, du : du + columns] for dv, du in shifts])
    farther, limit = around - depth, np.float32(ALIKE) * depth
    alike = (np.abs(farther) < limit).sum(axis=0)
    behind = ((around > 0) & (farther < -limit)).any(axis=0)
    thin = (alike >= MIN_ALIKE_FRONT) & ~behind
    return np.where(alike >= MIN_ALIKE, 1, np.where(thin, THIN_WEIGHT, 0))


@pytest.mark.parametrize("step", [1, 2])
def test_free_readings_equal_numpy(step):
    post = Box(0.1, 0.72, (0.004, 0.004, 0.14))
    frame, truth = solid_frame([THING, BOARD, post], (Plate(),), CAMERA)
    labels = (truth == 1).astype(np.int32)
    up = T_TABLE_CAMERA.as_matrix()[2]
    planes = np.array([[*up, MIN_HEIGHT], [*up[:3], up[3] - 0.1, 0.02]])
    k = frame.intrinsics.reduced(step)
    found = free_readings(frame.depth, labels, step, planes, (k.fx, k.fy, k.cx, k.cy))
    part = slice(None, None, step), slice(None, None, step)
    near = np.asarray(ndimage.binary_dilation(labels[part], np.ones((2 * EDGE + 1,) * 2)), bool)
    points = k.rays() * frame.depth[part].astype(np.float64)[..., None]
    heights = points @ up[:3] + up[3]
    free = (frame.depth[part] > 0) & ~near & (heights > MIN_HEIGHT) & (abs(heights - 0.1) > 0.02)
    counts = weights_with_numpy(frame.depth)[part]
    assert set(np.unique(counts[free])) == {0, 1, THIN_WEIGHT}
    np.testing.assert_allclose(found, np.repeat(points[free], counts[free], axis=0), atol=1e-12)

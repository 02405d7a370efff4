"""Tests of the votes for rectangles of edges: equality with NumPy."""

import numpy as np
import pytest

from eyehand.perception import CameraIntrinsics
from eyehand.perception.segmentation.rim_votes import count_visible

CAMERA = CameraIntrinsics(100.0, 110.0, 31.5, 23.5, 64, 48)


@pytest.mark.parametrize("seed", range(3))
def test_places_within_the_image_equal_numpy(seed):
    rng = np.random.default_rng(seed)
    base, direction = rng.uniform(-0.1, 0.1, (4, 3)), 0.3 * rng.normal(size=3)
    base[:, 2] += 0.4
    along = np.linspace(-1.0, 1.0, 30)
    points = base[:, None] + along[:, None] * direction
    pixels = CAMERA.project(points)
    inside = ((pixels > 0) & (pixels < [64, 48])).all(axis=-1)
    pinhole = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    counts = count_visible(base, along, direction, pinhole, np.zeros((48, 64), np.float32))
    assert np.array_equal(counts[:, 1:, 0], np.cumsum(inside, axis=1))
    assert np.array_equal(counts[..., 0], counts[..., 1])
    assert 0 < inside.sum() < inside.size
    assert not counts[:, 0].any()


def test_places_behind_a_reading_are_hidden():
    base, along = np.array([[-0.1, 0.0, 0.5]]), np.linspace(0.0, 0.2, 21)
    pinhole = CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy
    depth = np.full((48, 64), 0.49, np.float32)
    depth[:, 32:] = 0.4
    counts = count_visible(base, along, np.array([1.0, 0.0, 0.0]), pinhole, depth)
    assert counts[0, -1].tolist() == [21, 11]

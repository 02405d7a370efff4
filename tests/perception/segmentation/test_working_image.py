"""Tests of the working image: stride, median filter and inverse depth."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from synthetic_solids import T_TABLE_CAMERA

from eyehand.perception import CameraIntrinsics, DepthFrame
from eyehand.perception.segmentation.working_image import inverse, working_image


def random_frame(seed: int, missing: float = 0.3) -> DepthFrame:
    """Return a 13 x 18 px frame with colour, camera pose and missing readings."""
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.3, 3.0, (13, 18)).astype(np.float32)
    depth[rng.random(depth.shape) < missing] = 0.0
    depth[0, 0] = 1.0
    colour = rng.integers(0, 256, (13, 18, 3)).astype(np.uint8)
    return DepthFrame(depth, CameraIntrinsics(20.0, 21.0, 8.5, 6.0, 18, 13), T_TABLE_CAMERA, colour)


@given(seed=st.integers(0, 10_000), stride=st.integers(1, 20))
@settings(max_examples=15)
def test_stride_selects_unchanged_pixels(seed, stride):
    frame = random_frame(seed)
    image = working_image(frame, stride, median=False)
    assert np.array_equal(image.depth, frame.depth[::stride, ::stride])
    assert image.colour is not None
    assert frame.colour is not None
    assert np.array_equal(image.colour, frame.colour[::stride, ::stride])
    assert np.allclose(image.intrinsics.rays(), frame.intrinsics.rays()[::stride, ::stride])
    assert image.T_world_camera is T_TABLE_CAMERA


@given(seed=st.integers(0, 10_000), missing=st.sampled_from([0.0, 0.3, 0.8]))
@settings(max_examples=15)
def test_median_filter_equals_scipy_and_adds_no_reading(seed, missing):
    frame = random_frame(seed, missing)
    image = working_image(frame, 1, median=True)
    raw = inverse(frame.depth)
    median = ndimage.median_filter(raw, 3, mode="nearest")
    assert np.array_equal(image.disparity, np.where((raw > 0) & (median > 0), median, raw))
    assert np.array_equal(image.depth > 0, frame.valid)
    assert np.allclose(image.depth * image.disparity, frame.valid)


def test_stride_without_readings_gives_empty_image():
    depth = np.zeros((8, 8), np.float32)
    depth[1::2, 1::2] = 1.0
    frame = DepthFrame(depth, CameraIntrinsics(9.0, 9.0, 3.5, 3.5, 8, 8))
    assert not working_image(frame, 2, median=True).depth.any()


@pytest.mark.parametrize("value", [0.0, 1e-4, 0.5, 1.0, 1e4])
def test_inverse_is_finite_and_keeps_zero(value):
    image = np.full((2, 3), value, np.float32)
    assert np.allclose(inverse(inverse(image)), image)
    assert np.isfinite(inverse(image)).all()

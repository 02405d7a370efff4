"""Tests of the waves of a support: the kernel equals NumPy; only low blocks count."""

import numpy as np
import pytest
from synthetic_solids import CAMERA_HEIGHT, TABLE_AXES, Box, Plate, exact_image, solid_frame

from eyehand.perception import DepthFrame
from eyehand.perception.segmentation import SupportPlane
from eyehand.perception.segmentation.support_extent import Support
from eyehand.perception.segmentation.support_scatter import (
    DEFAULT_WAVE,
    MIN_SHARE,
    NEAR,
    block_heights,
    support_wave,
)

TABLE = Support(
    SupportPlane(TABLE_AXES[2], CAMERA_HEIGHT, 0.0005),
    np.zeros((4, 2), np.float32),
    TABLE_AXES[:2],
    0.8,
)


def wavy_frame(solids, amplitude):
    """Return a frame of a table whose disparity is bent by waves of a height at 0.8 m."""
    frame, labels = solid_frame(solids, (Plate(),))
    columns = np.arange(frame.depth.shape[1])
    bend = amplitude / (CAMERA_HEIGHT * 0.8) * np.sin(2 * np.pi * columns / 80.0)
    depth = np.where(frame.valid, 1.0 / (1.0 / np.maximum(frame.depth, 1e-6) + bend), 0.0)
    return DepthFrame(depth.astype(np.float32), frame.intrinsics), labels


def test_block_heights_equal_numpy():
    rng = np.random.default_rng(0)
    rows, columns, side, step, offset = 24, 32, 8, 2, 0.8
    max_difference = 0.001
    slopes = np.zeros(columns), -1.0 + 0.1 * rng.random(rows)
    true_z = offset / -slopes[1][:, None]
    depth = (true_z + rng.choice([0.0, 0.004, 0.1], (rows, columns), p=[0.7, 0.2, 0.1])).astype(
        np.float32
    )
    found = block_heights(depth, slopes, offset, (0.001, max_difference), (side, step))
    z = depth.astype(float)
    height = z * (slopes[0] + slopes[1][:, None]) + offset
    near = np.abs(height) < np.maximum(0.001 * z**2, NEAR)
    for k, m in np.ndindex(*found.shape):
        block = np.s_[k * side : (k + 1) * side : step, m * side : (m + 1) * side : step]
        sums = np.where(near[block], height[block], 0.0)
        difference = abs(sums[: len(sums) // 2].sum() - sums[len(sums) // 2 :].sum())
        level = difference < 0.5 * max_difference * z[block][near[block]].sum()
        if near[block].mean() < MIN_SHARE or not level:
            assert np.isnan(found[k, m])
        else:
            assert found[k, m] == pytest.approx((height / z**2)[block][near[block]].mean())
    assert np.isfinite(found).any()


@pytest.mark.parametrize("amplitude", [0.0, 0.002, 0.004])
def test_waves_are_measured(amplitude):
    frame, _ = wavy_frame([], amplitude)
    wave = support_wave(exact_image(frame), TABLE, 3.0) * 0.8**2
    # The mean over a block is lower than the crest.
    assert 0.7 * amplitude - 1e-4 <= wave <= 1.3 * amplitude + 1e-4


def test_flat_objects_are_no_waves():
    plates = [Box(x, 0.7, (0.1, 0.15, 0.004)) for x in (-0.15, 0.0, 0.15)]
    frame, labels = solid_frame(plates, (Plate(),))
    assert np.mean(labels > 0) > 0.03
    assert support_wave(exact_image(frame), TABLE, 3.0) * 0.8**2 < 2e-4


def test_hidden_support_has_default_waves():
    frame, _ = solid_frame([], (Plate(z=-0.2),))
    wave = support_wave(exact_image(frame), TABLE, 3.0)
    assert wave == pytest.approx(DEFAULT_WAVE / 0.8**2)

"""The depth noise: each term alone, and all terms together."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from eyehand.data_synth import DepthNoise, add_depth_noise
from eyehand.data_synth.render import axial_sigma
from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

CAMERA = CameraIntrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
NONE = DepthNoise.none()


def wall(z: float) -> NDArray[np.float32]:
    return np.full((480, 640), z, dtype=np.float32)


def step_image() -> NDArray[np.float32]:
    """Return a depth image with a near left half, a far right half, and no readings at the top."""
    depth = wall(0.8)
    depth[:, 320:] = 1.2
    depth[:50] = 0
    return depth


def slanted_plane(angle: float) -> NDArray[np.float32]:
    """Return the depth of a plane through (0, 0, 1) m at ``angle``, rad, to the optical axis."""
    rays = CAMERA.rays()
    return (1.0 / (1.0 + np.tan(angle) * rays[..., 1])).astype(np.float32)


def noisy(depth: NDArray, options: DepthNoise, seed: int = 0) -> NDArray[np.float32]:
    return add_depth_noise(depth, CAMERA, np.random.default_rng(seed), options)


def test_no_noise_is_identity():
    depth = step_image()
    out = noisy(depth, NONE)
    assert np.array_equal(out, depth)
    assert out is not depth


def test_zero_scale_is_no_noise():
    depth = step_image()
    assert np.array_equal(noisy(depth, DepthNoise.realistic(0.0)), depth)


def test_noise_is_repeatable_and_keeps_input():
    depth = step_image()
    original = depth.copy()
    one, other = noisy(depth, DepthNoise.realistic(), 3), noisy(depth, DepthNoise.realistic(), 3)
    assert np.array_equal(one, other)
    assert not np.array_equal(one, noisy(depth, DepthNoise.realistic(), 4))
    assert np.array_equal(depth, original)


@pytest.mark.parametrize("correlation", [0.0, 0.8, 2.0])
@pytest.mark.parametrize("z", [0.5, 1.0, 2.0])
def test_axial_noise_has_sigma_of_nguyen(z: float, correlation: float):
    error = noisy(wall(z), replace(NONE, axial=1.0, correlation=correlation)) - z
    expected = 0.0012 + 0.0019 * (z - 0.4) ** 2
    assert axial_sigma(np.array(z)) == pytest.approx(expected)
    assert error.std() == pytest.approx(expected, rel=0.04)
    assert abs(error.mean()) < 0.05 * expected


def test_axial_noise_scales_linearly():
    once = noisy(wall(1.0), replace(NONE, axial=1.0)) - 1
    twice = noisy(wall(1.0), replace(NONE, axial=1.0).scaled(2.0)) - 1
    assert twice.std() == pytest.approx(2 * once.std(), rel=1e-3)


def test_blurred_noise_is_correlated_between_neighbours():
    white = noisy(wall(1.0), replace(NONE, axial=1.0)) - 1
    blurred = noisy(wall(1.0), replace(NONE, axial=1.0, correlation=1.0)) - 1

    def correlation(field: NDArray) -> float:
        return float(np.corrcoef(field[:, 1:].ravel(), field[:, :-1].ravel())[0, 1])

    assert abs(correlation(white)) < 0.02
    # The correlation of Gaussian blurs one pixel apart is exp(-1 / 4).
    assert correlation(blurred) == pytest.approx(np.exp(-0.25), abs=0.02)


def test_lateral_jitter_follows_slope_and_adds_no_new_depths():
    depth = slanted_plane(0.6)
    error = noisy(depth, replace(NONE, lateral=0.5))[100:-100, 100:-100]
    error = error - depth[100:-100, 100:-100]
    slope = np.gradient(depth, axis=0)[100:-100, 100:-100]
    assert (error / slope).std() == pytest.approx(0.5, rel=0.05)
    stepped = noisy(step_image(), replace(NONE, lateral=0.4))
    assert set(np.unique(stepped)) <= {np.float32(0), np.float32(0.8), np.float32(1.2)}
    changed = np.nonzero(stepped[60:] != step_image()[60:])[1]
    assert len(changed) > 50
    assert changed.min() > 310
    assert changed.max() < 330


def test_disparity_steps_match_baseline():
    depth = np.tile(np.linspace(0.6, 2.0, 640, dtype=np.float32), (480, 1))
    out = noisy(depth, replace(NONE, disparity_step=0.125, baseline=0.075))
    levels = np.unique(525 * 0.075 / out.astype(np.float64) / 0.125)
    assert np.allclose(levels, np.rint(levels), atol=1e-3)
    half_step = depth.astype(np.float64) ** 2 * 0.125 / (525 * 0.075) / 2
    assert np.all(np.abs(out - depth) <= 1.05 * half_step + 1e-6)
    assert np.abs(out - depth).max() > 0.8 * half_step.max()


def test_depth_with_zero_disparity_is_invalid():
    out = noisy(wall(50.0), replace(NONE, disparity_step=4.0))
    assert not out.any()


def test_edge_dropout_affects_edges_only():
    depth = step_image()
    out = noisy(depth, replace(NONE, edge_dropout=0.3))
    lost = (out == 0) & (depth > 0)
    assert set(np.nonzero(lost)[1]) == {319, 320}
    assert lost[50:, 319:321].mean() == pytest.approx(0.3, abs=0.06)


def test_flying_pixels_lie_between_surfaces():
    depth = step_image()
    out = noisy(depth, replace(NONE, flying=0.5))
    changed = out != depth
    assert set(np.nonzero(changed)[1]) == {319, 320}
    assert changed[50:, 319:321].mean() == pytest.approx(0.5, abs=0.07)
    between = out[changed]
    assert np.all((between >= 0.8) & (between <= 1.2))
    assert between.mean() == pytest.approx(1.0, abs=0.03)


def test_grazing_dropout_affects_grazing_surfaces_only():
    options = replace(NONE, grazing_dropout=0.9)
    assert np.all(noisy(slanted_plane(0.5), options) > 0)
    assert np.all(noisy(step_image(), options)[60:] > 0)
    steep = slanted_plane(1.5)
    middle = (slice(238, 242), slice(None))
    lost = np.mean([noisy(steep, options, seed)[middle] == 0 for seed in range(5)])
    # The dropout is a ramp over the cosine, here at 1.5 rad between 1.31 and 1.52 rad.
    ramp = (np.cos(1.31) - np.cos(1.5)) / (np.cos(1.31) - np.cos(1.52))
    assert lost == pytest.approx(0.9 * ramp, abs=0.06)


def test_holes_have_requested_share_and_are_connected():
    out = noisy(wall(1.0), replace(NONE, hole_share=0.05))
    lost = out == 0
    assert lost.mean() == pytest.approx(0.05, abs=0.005)
    beside = (lost[:, 1:] & lost[:, :-1]).sum() / lost.sum()
    assert beside > 0.5
    assert np.all(out[~lost] == 1.0)


def test_hole_share_of_one_removes_all_readings():
    assert not noisy(wall(1.0), replace(NONE, hole_share=1.0)).any()


def test_realistic_noise_keeps_most_readings_accurate():
    depth = step_image()
    out = noisy(depth, DepthNoise.realistic())
    valid = (out > 0) & (depth > 0)
    assert valid.sum() > 0.98 * (depth > 0).sum()
    assert np.median(np.abs(out - depth)[valid]) < 0.004
    assert out.dtype == np.float32


@settings(max_examples=20, deadline=None)
@given(
    scale=st.floats(0, 8),
    seed=st.integers(0, 99),
    height=st.integers(1, 40),
    width=st.integers(1, 40),
)
def test_depth_is_finite_and_positive_for_any_scale_and_size(
    scale: float, seed: int, height: int, width: int
):
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0, 3, (height, width)).astype(np.float32)
    depth[rng.random(depth.shape) < 0.2] = 0
    camera = CameraIntrinsics(40.0, 40.0, width / 2, height / 2, width, height)
    out = add_depth_noise(depth, camera, rng, DepthNoise.realistic(scale))
    assert out.shape == depth.shape
    assert np.all(np.isfinite(out))
    assert np.all(out >= 0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"axial": -1.0}, "axial must be >= 0"),
        ({"lateral": float("nan")}, "lateral must be >= 0"),
        ({"flying": 1.1}, r"flying is a share and must lie in \[0, 1\], got 1.1"),
        ({"hole_share": -0.1}, "hole_share is a share"),
        ({"baseline": 0.0}, "baseline must be > 0"),
        ({"grazing_start": 1.5, "grazing_end": 1.4}, "must rise"),
    ],
)
def test_depth_noise_rejects_invalid_options(options: dict[str, Any], message: str):
    with pytest.raises(InputError, match=message):
        DepthNoise(**options)


def test_realistic_noise_rejects_negative_scale():
    with pytest.raises(InputError, match="scale must be >= 0"):
        DepthNoise.realistic(-1.0)


def test_add_depth_noise_rejects_mismatched_size():
    with pytest.raises(InputError, match=r"\(480, 640\), got \(4, 4\)"):
        noisy(np.ones((4, 4), np.float32), NONE)


def test_benchmark_add_depth_noise(benchmark: Any):
    depth = step_image()
    benchmark(noisy, depth, DepthNoise.realistic())

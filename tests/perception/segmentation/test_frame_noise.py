"""Tests of the frame noise: residuals equal least squares, and the quantile is robust."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.perception.segmentation.frame_noise import (
    MIN_NOISE,
    frame_noise,
    noise_profile,
    window_residuals,
)

WINDOW = 9


def reference(q, v, u, radius):
    """Return the RMS residual of the least-squares plane in one window, and the reading count."""
    rows, columns = np.indices(q.shape)
    inside = (abs(rows - v) <= radius) & (abs(columns - u) <= radius) & (q > 0)
    rows, columns = rows[inside], columns[inside]
    A = np.column_stack([np.ones(rows.size), columns, rows])
    target = q[inside].astype(float)
    fitted = A @ np.linalg.lstsq(A, target, rcond=None)[0]
    return np.sqrt(np.mean((fitted - target) ** 2)) if rows.size else 0.0, rows.size


@given(
    seed=st.integers(0, 10_000),
    radius=st.integers(1, 3),
    step=st.integers(1, 4),
    share=st.floats(0.0, 0.6),
)
@settings(max_examples=20)
def test_residuals_equal_least_squares(seed, radius, step, share):
    rng = np.random.default_rng(seed)
    q = rng.uniform(0.8, 1.2, (11, 13)).astype(np.float32)
    q[rng.random(q.shape) < share] = 0.0
    result = window_residuals(q, radius, step, 0.5)
    assert result.shape == (-(-11 // step), -(-13 // step))
    min_count = max(0.5 * (2 * radius + 1) ** 2, 4.0)
    for k, m in np.ndindex(result.shape):
        expected, count = reference(q, k * step, m * step, radius)
        if result[k, m] >= 0:
            assert result[k, m] == pytest.approx(expected, abs=1e-6)
        else:
            # Few or collinear readings give no plane.
            assert count < min_count or radius == 1


def test_collinear_readings_give_no_plane():
    q = np.zeros((9, 9), np.float32)
    q[4] = 1.0
    assert np.all(window_residuals(q, 1, 1, 0.3) == -1.0)


def test_too_few_readings_give_min_noise():
    q = np.zeros((20, 20), np.float32)
    q[3, 4] = 1.0
    assert frame_noise(q, WINDOW) == MIN_NOISE


@given(a=st.floats(-0.002, 0.002), b=st.floats(-0.002, 0.002), sigma=st.sampled_from([0.003, 0.01]))
@settings(max_examples=10)
def test_plane_slope_is_no_noise(a, b, sigma):
    v, u = np.indices((60, 80))
    noise = sigma * np.random.default_rng(1).normal(size=u.shape)
    q = (1.0 + a * u + b * v + noise).astype(np.float32)
    # The plane takes three of the 81 degrees of freedom of a window.
    assert frame_noise(q, WINDOW) == pytest.approx(sigma, rel=0.08)


def test_depth_edges_are_no_noise():
    rng = np.random.default_rng(2)
    u = np.indices((120, 160))[1]
    stripes = 1.0 + 0.2 * (u // 40) + 0.001 * rng.normal(size=u.shape)
    assert frame_noise(stripes.astype(np.float32), WINDOW) < 0.0013


def test_profile_rises_only_where_noise_is_clearly_higher():
    near = np.indices((240, 320))[1] > 160
    rng = np.random.default_rng(3)
    q = np.where(near, 2.5, 1.0) + np.where(near, 0.01, 0.002) * rng.normal(size=near.shape)
    noise, profile = noise_profile(q.astype(np.float32), WINDOW)
    assert profile.at(1.0) == noise == pytest.approx(0.002, rel=0.1)
    assert profile.at(2.5) == pytest.approx(0.01, rel=0.1)


def test_profile_without_windows_is_min_noise():
    noise, profile = noise_profile(np.zeros((20, 20), np.float32), WINDOW)
    assert noise == profile.at(1.0) == MIN_NOISE

"""Compiled functions of the plane search equal NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eyehand.perception.segmentation.parallel_planes import FlatReadings
from eyehand.perception.segmentation.plane_votes import (
    MIN_COSINE,
    REFITS,
    facing_rays,
    fit_tukey_plane,
    plane_distances,
    plane_inliers,
    score_planes,
)
from eyehand.perception.segmentation.support_plane import PlaneSamples


def random_samples(seed):
    """Return candidate planes and samples of them, with some outliers."""
    rng = np.random.default_rng(seed)
    count = 80
    rays = np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), np.ones(count)])
    planes = rng.normal(size=(6, 3)) * 0.1 - [0.0, 0.0, 1.0]
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    offsets = rng.uniform(0.5, 1.5, 6)
    plane_index = rng.integers(0, 6, count)
    q = -np.einsum("ij,ij->i", planes[plane_index], rays) / offsets[
        plane_index
    ] + 0.02 * rng.normal(size=count)
    normals = planes[plane_index] + 0.2 * rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return planes, offsets, q, rays, normals


@given(seed=st.integers(0, 10_000), tolerance=st.floats(0.005, 0.1))
@settings(max_examples=20)
def test_inliers_equal_numpy(seed, tolerance):
    planes, offsets, q, rays, normals = random_samples(seed)
    expected = np.abs(rays @ planes.T / offsets + q[:, None]) < tolerance
    expected &= normals @ planes.T > MIN_COSINE
    bands = np.full(len(q), tolerance)
    found = plane_inliers(planes, offsets, PlaneSamples(q, rays, normals), bands)
    assert np.array_equal(found, expected.T)


@given(seed=st.integers(0, 10_000))
@settings(max_examples=20)
def test_tukey_fit_equals_numpy(seed):
    rng = np.random.default_rng(seed)
    rays = np.column_stack([rng.uniform(-0.5, 0.5, (200, 2)), np.ones(200)])
    truth = np.array([0.3, -0.8, 1.2])
    q = rays @ truth + 0.01 * rng.normal(size=200)
    q[:40] += rng.uniform(0.1, 0.5, 40)
    start, width = truth + 0.005 * rng.normal(size=3), np.full(200, 0.06)
    expected = start
    for _ in range(REFITS):
        roots = np.maximum(1.0 - ((rays @ expected - q) / width) ** 2, 0.0)
        expected = np.linalg.lstsq(roots[:, None] * rays, roots * q, rcond=None)[0]
    assert np.allclose(fit_tukey_plane(start, rays, q, width), expected, atol=1e-9)


def test_tukey_fit_needs_samples_that_span_a_plane():
    rays = np.column_stack([np.linspace(-0.5, 0.5, 30), np.zeros(30), np.ones(30)])
    truth, width = np.array([0.3, -0.8, 1.2]), np.full(30, 0.06)
    assert not fit_tukey_plane(truth, rays, rays @ truth, width).any()
    assert not fit_tukey_plane(truth, rays, rays @ truth + 1.0, width).any()


def test_scores_equal_numpy():
    rng = np.random.default_rng(0)
    inliers, weights = rng.random((7, 301)) < 0.4, rng.random(301)
    np.testing.assert_allclose(score_planes(inliers, weights), inliers @ weights, rtol=1e-12)


def test_equal_inliers_have_equal_scores():
    inliers = np.tile(np.random.default_rng(1).random(301) < 0.4, (7, 1))
    assert len(set(score_planes(inliers, np.random.default_rng(2).random(301)).tolist())) == 1


def test_facing_rays_equal_numpy():
    rng = np.random.default_rng(3)
    points = rng.normal([0.0, 0.0, 2.0], 1.0, (200, 3))
    normals = rng.normal(size=(200, 3)) * 0.2 - [0.0, 0.0, 1.0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normal = np.array([0.0, 0.0, -1.0])
    rays, depths = facing_rays(FlatReadings(points, normals.astype(np.float32), 1.0), normal)
    expected = points[normals @ normal > MIN_COSINE]
    assert 0 < len(expected) < 200
    assert np.array_equal(rays, expected / expected[:, 2:])
    assert np.array_equal(depths, expected[:, 2])


def test_distances_equal_numpy():
    rng = np.random.default_rng(4)
    n = np.array([0.3, -0.8, 1.2])
    rays = np.column_stack([rng.uniform(-0.5, 0.5, (200, 2)), np.ones(200)])
    z = 1.0 / (rays @ n + 0.05 * rng.normal(size=200))
    tolerance = rng.uniform(0.01, 0.1, 200)
    length = np.linalg.norm(n)
    inliers, distances = plane_distances(n, (-n / length, 1.0 / length), rays, z, tolerance)
    expected = np.abs(rays @ n - 1.0 / z) < tolerance
    assert 0 < np.count_nonzero(expected) < 200
    assert np.array_equal(inliers, expected)
    heights = (rays * z[:, None])[expected] @ (-n / length) + 1.0 / length
    assert distances == pytest.approx(np.abs(heights), abs=1e-12)

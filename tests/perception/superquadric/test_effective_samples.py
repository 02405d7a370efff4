"""Tests of the effective sample size: correlated residuals count once."""

from functools import partial

import numpy as np
import pytest
from scipy.spatial import KDTree

from eyehand.perception.superquadric.effective_samples import (
    MAX_SAMPLES,
    MIN_SAMPLES,
    PATCH_SIZE,
    TRUSTED_SHARE,
    effective_sample_size,
)

samples_without_limit = partial(effective_sample_size, max_samples=1e6)


def sheet(seed, count):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 1.0, (count, 3)) * [1.0, 1.0, 0.0], rng.normal(size=count)


def smoothed(points, values, width):
    """Return the mean over each point and its nearest neighbours."""
    # Query one neighbour more, so that KDTree returns a table also for width 1.
    neighbours = np.asarray(KDTree(points).query(points, k=width + 1)[1])[:, :width]
    return values[neighbours].mean(axis=1)


@pytest.mark.parametrize("count", [1000, 4000])
def test_white_noise_gives_samples_proportional_to_points(count):
    samples = np.array([samples_without_limit(*sheet(seed, count)) for seed in range(12)])
    assert np.all(samples <= TRUSTED_SHARE * count)
    assert np.median(samples) > 0.5 * TRUSTED_SHARE * count


def test_smoother_noise_gives_fewer_samples():
    for seed in range(5):
        points, noise = sheet(seed, 3000)
        samples = [
            samples_without_limit(points, smoothed(points, noise, width))
            for width in (1, 5, 15, 40)
        ]
        assert samples == sorted(samples, reverse=True)
        assert samples[-1] < 0.1 * samples[0]


def test_noise_shared_by_patch_counts_once():
    # All points of a group share one position and one residual: a group is one sample.
    rng = np.random.default_rng(0)
    groups, group_size = 120, PATCH_SIZE + 1
    centres = np.repeat(rng.uniform(0.0, 1.0, (groups, 3)), group_size, axis=0)
    points = centres + 1e-6 * rng.normal(size=centres.shape)
    order = rng.permutation(len(points))
    samples = samples_without_limit(
        points[order], np.repeat(rng.normal(size=groups), group_size)[order]
    )
    assert samples == pytest.approx(TRUSTED_SHARE * groups, rel=0.25)


def test_common_bias_gives_min_samples():
    points, _ = sheet(0, 600)
    assert effective_sample_size(points, np.ones(600)) == MIN_SAMPLES


def test_two_outliers_change_samples_little():
    points, noise = sheet(3, 2000)
    with_outliers = noise.copy()
    with_outliers[[7, 700]] = 1e6
    samples_before, samples_after = (
        samples_without_limit(points, values) for values in (noise, with_outliers)
    )
    assert samples_after == pytest.approx(samples_before, rel=0.2)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_samples_do_not_depend_on_unit(unit):
    points, noise = sheet(2, 1500)
    samples = samples_without_limit(unit * points, 0.01 * unit * smoothed(points, noise, 8))
    assert samples == pytest.approx(samples_without_limit(points, smoothed(points, noise, 8)))


def test_samples_stay_within_limits():
    points, noise = sheet(1, 3000)
    assert effective_sample_size(points, noise) == MAX_SAMPLES
    assert effective_sample_size(points, np.zeros(3000)) == MAX_SAMPLES
    for count in (1, 20, 60, 61, 120):
        assert effective_sample_size(points[:count], noise[:count]) >= MIN_SAMPLES
    assert effective_sample_size(points, noise, 20.0) == 20.0

"""Residuals that agree with their neighbours' count once, those that do not count each."""

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

unlimited = partial(effective_sample_size, max_samples=1e6)


def sheet(seed, count):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 1.0, (count, 3)) * [1.0, 1.0, 0.0], rng.normal(size=count)


def smoothed(points, values, width):
    """Means over each point and its nearest neighbours."""
    # One neighbour more than needed, for a table of one column is no table.
    near = np.asarray(KDTree(points).query(points, k=width + 1)[1])[:, :width]
    return values[near].mean(axis=1)


@pytest.mark.parametrize("count", [1000, 4000])
def test_white_noise_gives_readings_in_the_number_of_points(count):
    found = np.array([unlimited(*sheet(seed, count)) for seed in range(12)])
    assert np.all(found <= TRUSTED_SHARE * count)
    assert np.median(found) > 0.5 * TRUSTED_SHARE * count


def test_the_smoother_the_noise_the_fewer_readings():
    for seed in range(5):
        points, noise = sheet(seed, 3000)
        found = [unlimited(points, smoothed(points, noise, width)) for width in (1, 5, 15, 40)]
        assert found == sorted(found, reverse=True)
        assert found[-1] < 0.1 * found[0]


def test_noise_shared_by_patches_counts_once_a_patch():
    # Groups of points at one place each, one residual a group: a group is one reading.
    rng = np.random.default_rng(0)
    groups, each = 120, PATCH_SIZE + 1
    places = np.repeat(rng.uniform(0.0, 1.0, (groups, 3)), each, axis=0)
    points = places + 1e-6 * rng.normal(size=places.shape)
    order = rng.permutation(len(points))
    found = unlimited(points[order], np.repeat(rng.normal(size=groups), each)[order])
    assert found == pytest.approx(TRUSTED_SHARE * groups, rel=0.25)


def test_a_bias_shared_by_all_leaves_the_fewest():
    points, _ = sheet(0, 600)
    assert effective_sample_size(points, np.ones(600)) == MIN_SAMPLES


def test_two_outliers_among_many_change_little():
    points, noise = sheet(3, 2000)
    wild = noise.copy()
    wild[[7, 700]] = 1e6
    before, after = (unlimited(points, values) for values in (noise, wild))
    assert after == pytest.approx(before, rel=0.2)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_units_do_not_matter(unit):
    points, noise = sheet(2, 1500)
    found = unlimited(unit * points, 0.01 * unit * smoothed(points, noise, 8))
    assert found == pytest.approx(unlimited(points, smoothed(points, noise, 8)))


def test_readings_stay_between_the_fewest_and_the_options():
    points, noise = sheet(1, 3000)
    assert effective_sample_size(points, noise) == MAX_SAMPLES
    assert effective_sample_size(points, np.zeros(3000)) == MAX_SAMPLES
    for count in (1, 20, 60, 61, 120):
        assert effective_sample_size(points[:count], noise[:count]) >= MIN_SAMPLES
    assert effective_sample_size(points, noise, 20.0) == 20.0

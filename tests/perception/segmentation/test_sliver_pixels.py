"""Tests of the compiled steps on slivers: they equal NumPy and SciPy."""

from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from eyehand.perception.segmentation.sliver_pixels import (
    clear_borders,
    measure_patches,
    replace_by_nearest,
)


def random_patches(seed):
    """Return blotchy labels 0..5, (H, W)."""
    field = ndimage.gaussian_filter(np.random.default_rng(seed).random((40, 50)), 2)
    return np.clip((field - field.mean()) / field.std() * 2 + 2.5, 0, 5).astype(np.int32)


@pytest.mark.parametrize("seed", range(4))
def test_replacement_is_nearest_within_reach(seed):
    patches, reach = random_patches(seed), 3
    replaced = np.array([False, True, False, True, False, False])
    found = replace_by_nearest(patches, replaced, reach)
    kept = (patches > 0) & ~replaced[patches]
    distance: Any = ndimage.distance_transform_edt(~kept)
    filled = replaced[patches] & (distance <= reach)
    assert np.array_equal(found > 0, kept | filled)
    assert np.array_equal(found[kept], patches[kept])
    for v, u in np.argwhere(filled):
        apart = np.hypot(*(np.argwhere(found[v, u] == np.where(kept, patches, 0)) - [v, u]).T)
        assert apart.min() == pytest.approx(distance[v, u])


@pytest.mark.parametrize("seed", range(4))
def test_borders_are_cleared(seed):
    patches = random_patches(seed)
    mask = np.ones(patches.shape, np.uint8)
    clear_borders(patches, mask)
    expected = np.zeros(patches.shape, bool)
    for v, u in np.ndindex(*patches.shape):
        inside = 0 < v < patches.shape[0] - 1 and 0 < u < patches.shape[1] - 1
        around = patches[[v - 1, v, v, (v + 1) % 40], [u, u - 1, (u + 1) % 50, u]]
        meets = patches[v, u] > 0 and np.any((around > 0) & (around != patches[v, u]))
        expected[v, u] = inside and not meets
    assert np.array_equal(mask > 0, expected)


def test_patches_are_measured():
    patches = random_patches(0)
    distance = np.random.default_rng(1).random(patches.shape, np.float32)
    sizes, largest = measure_patches(patches, distance, 6)
    assert np.array_equal(sizes, np.bincount(patches.ravel(), minlength=7))
    assert largest.tolist() == [distance[patches == k].max(initial=0) for k in range(7)]

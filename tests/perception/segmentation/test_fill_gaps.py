"""Tests of filled gaps: random ones are filled, seams and shadows stay; equality with NumPy."""

import numpy as np
import pytest

from eyehand.perception.segmentation.fill_gaps import (
    MAX_STEP,
    PASSES,
    count_changes,
    fill_between,
    fill_gaps,
    mark_gaps,
)


def sloping(rows=60, columns=80):
    """Return the disparity of a tilted plane."""
    v, u = np.indices((rows, columns))
    return (1.2 + 0.002 * u + 0.001 * v).astype(np.float32)


def reference(q, gaps):
    filled = q.astype(float)
    for _ in range(PASSES):
        source = filled.copy()
        for v, u in np.argwhere(gaps & (source == 0)):
            if not (0 < v < q.shape[0] - 1 and 0 < u < q.shape[1] - 1):
                continue
            pairs = [
                (source[v - dv, u - du], source[v + dv, u + du])
                for dv, du in ((0, 1), (1, 0), (1, 1), (1, -1))
            ]
            steps = [abs(a - b) / max(a, b) if min(a, b) > 0 else 1.0 for a, b in pairs]
            best = int(np.argmin(steps))
            if steps[best] < MAX_STEP:
                filled[v, u] = sum(pairs[best]) / 2
    return filled


@pytest.mark.parametrize("seed", range(3))
def test_filling_equals_numpy(seed):
    rng = np.random.default_rng(seed)
    q = sloping(20, 25) + (rng.random((20, 25)) < 0.3).astype(np.float32)
    q[rng.random(q.shape) < 0.5] = 0.0
    gaps = rng.random(q.shape) < 0.9
    assert np.allclose(fill_between(q, gaps), reference(q, gaps), atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_changes_and_gaps_equal_numpy(seed):
    rng = np.random.default_rng(seed)
    q = (rng.random((20, 25)) < 0.5).astype(np.float32)
    changes = np.zeros(q.shape, np.uint8)
    changes[:, 1:] += q[:, 1:] != q[:, :-1]
    changes[1:] += q[1:] != q[:-1]
    assert np.array_equal(count_changes(q), changes)
    gaps, count = mark_gaps(q, changes, 1.5)
    assert np.array_equal(gaps, (q == 0) & (changes == 2))
    assert count == np.count_nonzero(gaps) > 0


@pytest.mark.parametrize("share", [0.3, 0.4, 0.6])
def test_random_gaps_are_filled(share):
    q = sloping()
    holes = np.random.default_rng(0).random(q.shape) < share
    filled = fill_gaps(np.where(holes, np.float32(0.0), q))
    inner = np.s_[5:-5, 5:-5]
    assert np.mean(filled[inner] > 0) > 0.85
    assert np.abs(filled - q)[filled > 0].max() < 1e-3


def test_seam_and_shadow_stay():
    q = sloping()
    q[:, 40] = 0.0
    q[10:30, 10:20] = 0.0
    q[np.arange(30, 60), np.arange(45, 75)] = 0.0
    assert np.array_equal(fill_gaps(q), q)


def test_step_is_not_bridged():
    q = sloping()
    q[:, 40:] *= np.float32(1.2)
    holes = np.random.default_rng(0).random(q.shape) < 0.4
    filled = fill_gaps(np.where(holes, np.float32(0.0), q))
    assert np.abs(filled - q)[filled > 0].max() < 1e-3

"""Tests of cross products and right-handed frames."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.perpendicular import cross, perpendicular_pair

seeds = st.integers(0, 2**31 - 1)


@given(seed=seeds)
def test_cross_product_equals_numpy(seed):
    a, b = np.random.default_rng(seed).normal(size=(2, 3))
    assert np.array_equal(cross(a, b), np.cross(a, b))


@given(seed=seeds, axis=st.sampled_from([None, 0, 1, 2]))
def test_pair_completes_right_handed_frame(seed, axis):
    direction = np.random.default_rng(seed).normal(size=3) if axis is None else np.eye(3)[axis]
    direction = direction / np.linalg.norm(direction)
    a, b = perpendicular_pair(direction)
    frame = np.column_stack([a, b, direction])
    assert np.allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.isclose(np.linalg.det(frame), 1.0)


def test_zero_direction_has_no_pair():
    assert np.isnan(perpendicular_pair(np.zeros(3))).all()

"""Exponentials and logarithms of rows equal NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.superquadric.vector_kernels import exp_row, log1p_row, log_row

ROUNDING = 4 * np.finfo(np.float64).eps
sizes = st.integers(1, 150)
seeds = st.integers(0, 2**31 - 1)


def of(kernel, argument):
    """Apply a kernel to the middle one of three rows; the result is in it or in the first."""
    m = np.full((3, len(argument)), np.nan)
    m[1] = argument
    bits, n = m.view(np.int64), len(argument)
    if kernel is log1p_row:
        kernel(m, bits, 1, 0, 2, n)
        assert np.array_equal(m[1], argument)
        return m[0]
    kernel(m, bits, 1, 2, n)
    return m[1]


@given(seed=seeds, size=sizes)
def test_exponentials_over_their_whole_range(seed, size):
    argument = np.random.default_rng(seed).uniform(-690.0, 690.0, size)
    assert np.allclose(of(exp_row, argument), np.exp(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_logarithms_over_their_whole_range(seed, size):
    rng = np.random.default_rng(seed)
    argument = np.concatenate([10.0 ** rng.uniform(-300, 300, size), rng.uniform(0.5, 2.0, size)])
    assert np.allclose(of(log_row, argument), np.log(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_logarithms_beside_one_keep_what_is_added(seed, size):
    argument = 10.0 ** np.random.default_rng(seed).uniform(-30, 30, size)
    # Half a unit in the last place of 1 is what a small sum may be off by.
    assert np.allclose(of(log1p_row, argument), np.log1p(argument), rtol=ROUNDING, atol=1e-20)


@pytest.mark.parametrize("value", [-1e9, -701.0, 701.0, 1e9])
def test_exponentials_beyond_the_range_are_held_at_its_end(value):
    held = of(exp_row, np.array([value]))[0]
    assert held == pytest.approx(np.exp(np.sign(value) * 700.0))


def test_lanes_beyond_the_first_stay():
    m = np.array([[0.25, 1.0, 3.0], [0.0, 0.0, 0.0]])
    log_row(m, m.view(np.int64), 0, 1, 2)
    assert np.allclose(m[0], [np.log(0.25), 0.0, 3.0], rtol=ROUNDING)
    exp_row(m, m.view(np.int64), 0, 1, 2)
    assert np.allclose(m[0], [0.25, 1.0, 3.0], rtol=ROUNDING)

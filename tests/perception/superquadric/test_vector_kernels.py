"""Tests of exp and log kernels on rows: they equal NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.superquadric.vector_kernels import exp_row, log1p_row, log_row

ROUNDING = 4 * np.finfo(np.float64).eps
sizes = st.integers(1, 150)
seeds = st.integers(0, 2**31 - 1)


def apply_kernel(kernel, argument):
    """Apply a kernel to the second of three rows and return its result row."""
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
def test_exp_equals_numpy_over_full_range(seed, size):
    argument = np.random.default_rng(seed).uniform(-690.0, 690.0, size)
    assert np.allclose(apply_kernel(exp_row, argument), np.exp(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_log_equals_numpy_over_full_range(seed, size):
    rng = np.random.default_rng(seed)
    argument = np.concatenate([10.0 ** rng.uniform(-300, 300, size), rng.uniform(0.5, 2.0, size)])
    assert np.allclose(apply_kernel(log_row, argument), np.log(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_log1p_is_accurate_for_small_arguments(seed, size):
    argument = 10.0 ** np.random.default_rng(seed).uniform(-30, 30, size)
    # The absolute tolerance covers arguments near 1e-30.
    assert np.allclose(
        apply_kernel(log1p_row, argument), np.log1p(argument), rtol=ROUNDING, atol=1e-20
    )


@pytest.mark.parametrize("value", [-1e9, -701.0, 701.0, 1e9])
def test_exp_clamps_arguments(value):
    clamped = apply_kernel(exp_row, np.array([value]))[0]
    assert clamped == pytest.approx(np.exp(np.sign(value) * 700.0))


def test_lanes_beyond_count_are_unchanged():
    m = np.array([[0.25, 1.0, 3.0], [0.0, 0.0, 0.0]])
    log_row(m, m.view(np.int64), 0, 1, 2)
    assert np.allclose(m[0], [np.log(0.25), 0.0, 3.0], rtol=ROUNDING)
    exp_row(m, m.view(np.int64), 0, 1, 2)
    assert np.allclose(m[0], [0.25, 1.0, 3.0], rtol=ROUNDING)

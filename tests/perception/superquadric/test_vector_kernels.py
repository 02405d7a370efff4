"""Exponentials and logarithms of arrays equal NumPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eyehand.perception.superquadric.vector_kernels import exp_all, log1p_all, log_all

ROUNDING = 4 * np.finfo(np.float64).eps
sizes = st.integers(1, 150)
seeds = st.integers(0, 2**31 - 1)


def of(kernel, argument):
    out = np.empty_like(argument)
    kernel(argument, out, np.empty_like(argument))
    return out


@given(seed=seeds, size=sizes)
def test_exponentials_over_their_whole_range(seed, size):
    argument = np.random.default_rng(seed).uniform(-690.0, 690.0, size)
    assert np.allclose(of(exp_all, argument), np.exp(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_logarithms_over_their_whole_range(seed, size):
    rng = np.random.default_rng(seed)
    argument = np.concatenate([10.0 ** rng.uniform(-300, 300, size), rng.uniform(0.5, 2.0, size)])
    assert np.allclose(of(log_all, argument), np.log(argument), rtol=ROUNDING, atol=0.0)


@given(seed=seeds, size=sizes)
def test_logarithms_beside_one_keep_what_is_added(seed, size):
    argument = 10.0 ** np.random.default_rng(seed).uniform(-30, 30, size)
    # Half a unit in the last place of 1 is what a small sum may be off by.
    assert np.allclose(of(log1p_all, argument), np.log1p(argument), rtol=ROUNDING, atol=1e-20)


@pytest.mark.parametrize("value", [-1e9, -701.0, 701.0, 1e9])
def test_exponentials_beyond_the_range_are_held_at_its_end(value):
    held = of(exp_all, np.array([value]))[0]
    assert held == pytest.approx(np.exp(np.sign(value) * 700.0))


def test_an_array_may_be_its_own_result():
    row = np.array([0.25, 1.0, 3.0])
    expected = np.log(row)
    log_all(row, row, np.empty(3))
    assert np.allclose(row, expected, rtol=ROUNDING)
    exp_all(row, row, np.empty(3))
    assert np.allclose(row, [0.25, 1.0, 3.0], rtol=ROUNDING)

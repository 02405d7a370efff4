"""Tests of the compiled median and quantile."""

import numpy as np
import pytest

from eyehand.perception.segmentation.median import median, quantile


@pytest.mark.parametrize("count", [1, 2, 7, 300, 301])
def test_median_equals_numpy(count):
    values = np.random.default_rng(count).normal(size=count)
    assert median(values) == np.median(values)
    assert median(np.column_stack([values, values])[:, 1]) == np.median(values)


@pytest.mark.parametrize("count", [1, 2, 7, 300, 301])
@pytest.mark.parametrize("share", [0.0, 0.02, 0.4, 0.5, 0.95, 1.0])
def test_quantile_equals_numpy(count, share):
    values = np.random.default_rng(count).normal(size=count)
    assert quantile(values, share) == np.quantile(values, share)

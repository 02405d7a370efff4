"""Tests of the compiled median."""

import numpy as np
import pytest

from eyehand.perception.segmentation.median import median


@pytest.mark.parametrize("count", [1, 2, 7, 300, 301])
def test_median_equals_numpy(count):
    values = np.random.default_rng(count).normal(size=count)
    assert median(values) == np.median(values)
    assert median(np.column_stack([values, values])[:, 1]) == np.median(values)

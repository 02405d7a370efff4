"""Tests of the extent of points and of the range of numbers."""

import numpy as np
import pytest

from eyehand.perception.segmentation.point_extent import box_diagonal, trimmed_range


@pytest.mark.parametrize("count", [1, 2, 300])
def test_diagonal_equals_numpy(count):
    points = np.random.default_rng(count).normal(size=(count, 3))
    assert box_diagonal(points) == pytest.approx(np.linalg.norm(np.ptp(points, axis=0)))


def test_no_points_have_no_diagonal():
    assert box_diagonal(np.zeros((0, 3))) == 0.0


@pytest.mark.parametrize("count", [1, 2, 26, 300])
@pytest.mark.parametrize("outliers", [0.01, 0.02])
def test_range_equals_numpy(count, outliers):
    values = np.random.default_rng(count).normal(size=count)
    ordered, skipped = np.sort(values), round(outliers * (count - 1))
    expected = ordered[skipped], ordered[count - 1 - skipped]
    assert trimmed_range(values, outliers) == expected

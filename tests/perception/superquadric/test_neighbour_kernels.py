"""The nearest neighbours equal those of a KD-tree."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import KDTree

from eyehand.perception.superquadric.neighbour_kernels import nearest_neighbours

LINE, PLANE = np.array([1.0, 0.0, 0.0]), np.array([1.0, 1.0, 0.0])


def assert_nearest(points: NDArray[np.float64], queries: NDArray[np.float64], count: int) -> None:
    distances, indices = nearest_neighbours(points, queries, count)
    expected = np.reshape(KDTree(points).query(queries, k=count)[0], distances.shape)
    np.testing.assert_allclose(distances, expected, rtol=1e-12, atol=1e-15)
    offsets = points[indices] - queries[:, None]
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=-1), distances, rtol=1e-12, atol=1e-15)
    assert all(len(set(row)) == count for row in indices.tolist())


@given(
    seed=st.integers(0, 1000),
    size=st.integers(1, 300),
    count=st.integers(1, 31),
    stretch=st.sampled_from([(1, 1, 1), (1, 0.01, 5), (0, 1, 1), (0, 0, 1), (0, 0, 0)]),
)
def test_neighbours_of_points_and_of_places_far_away(seed, size, count, stretch):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(size, 3)) * stretch + rng.normal(size=3)
    queries = np.concatenate([points[:20], 3.0 * rng.normal(size=(20, 3))])
    assert_nearest(points, queries, min(count, size))


@pytest.mark.parametrize("axes", [LINE, LINE[::-1], PLANE, PLANE[::-1]])
def test_points_on_a_grid_have_many_equal_distances(axes):
    grid = np.stack(np.meshgrid(*[np.arange(8.0)] * 3), axis=-1).reshape(-1, 3)
    points = np.unique(grid * axes, axis=0)
    assert_nearest(points, points, 5)


def test_a_far_point_leaves_all_others_in_few_cells():
    points = np.concatenate([np.random.default_rng(0).normal(size=(500, 3)), [[1e6, 0.0, 0.0]]])
    assert_nearest(points, points, 7)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_not_finite_have_no_neighbours(bad):
    points = np.random.default_rng(1).normal(size=(60, 3))
    wrong = np.where(np.arange(60)[:, None] == 7, bad, points)
    for cloud, queries in ((wrong, points), (points, wrong), (points[:0], points)):
        distances, indices = nearest_neighbours(cloud, queries, 3)
        assert np.isinf(distances).all()
        assert not indices.any()

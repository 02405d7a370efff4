"""Tests of removing outliers: independent of point order and frame."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.outliers import remove_outliers

VIEW = np.zeros(3)
FOCAL = 600.0
seeds = st.integers(0, 2**31 - 1)


def image_cloud(rng, step=1, noise=0.001) -> np.ndarray:
    """Return the points of a ball on every `step`-th pixel of an image, with depth noise."""
    centre, radius = np.array([0.02, -0.01, 0.6]), 0.05
    u, v = np.meshgrid(np.arange(-90, 130, step), np.arange(-110, 110, step))
    rays = np.column_stack([u.ravel() / FOCAL, v.ravel() / FOCAL, np.ones(u.size)])
    square, middle = np.sum(rays**2, axis=1), rays @ centre
    discriminant = middle**2 - square * (centre @ centre - radius**2)
    depth = (middle[discriminant > 0] - np.sqrt(discriminant[discriminant > 0])) / square[
        discriminant > 0
    ]
    return rays[discriminant > 0] * (depth + noise * rng.normal(size=depth.size))[:, None]


def random_cloud(rng, count=600) -> np.ndarray:
    """Return random points on the visible side of the same ball."""
    pose = RigidTransform.from_translation([0.02, -0.01, 0.6])
    ball = Superquadric(np.full(3, 0.05), (1.0, 1.0), pose)
    points = sample_surface(ball, 3 * count, rng)
    points = points[np.einsum("ij,ij->i", -points, ball.normals(points)) > 0][:count]
    return points + 0.001 * rng.normal(size=points.shape)


def rows(cloud: np.ndarray) -> set[tuple[float, ...]]:
    return {tuple(point) for point in cloud.tolist()}


@given(seed=seeds)
@settings(max_examples=20)
def test_result_does_not_depend_on_order_or_frame(seed):
    rng = np.random.default_rng(seed)
    cloud = np.vstack([random_cloud(rng), rng.uniform([-0.3, -0.3, 0.3], [0.3, 0.3, 0.9], (60, 3))])
    reference = remove_outliers(cloud, VIEW)
    order = rng.permutation(len(cloud))
    permuted = remove_outliers(cloud[order], VIEW)
    assert rows(permuted.points) == rows(reference.points)
    assert permuted.pitch == pytest.approx(reference.pitch, rel=1e-9)
    T = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    transformed = remove_outliers(T.apply(cloud), T.apply(VIEW))
    assert len(transformed.points) == len(reference.points)
    assert np.allclose(transformed.points, T.apply(reference.points), atol=1e-12)
    assert transformed.pitch == pytest.approx(reference.pitch, rel=1e-9)
    assert transformed.on_grid == reference.on_grid


@pytest.mark.parametrize("view", [None, VIEW])
def test_isolated_points_are_removed_and_surface_kept(view):
    rng = np.random.default_rng(0)
    surface = random_cloud(rng)
    lone = rng.uniform([-0.4, -0.4, 0.2], [0.4, 0.4, 1.0], (80, 3))
    lone = lone[np.abs(np.linalg.norm(lone - [0.02, -0.01, 0.6], axis=1) - 0.05) > 0.03]
    kept = rows(remove_outliers(np.vstack([surface, lone]), view).points)
    assert not kept & rows(lone)
    assert len(kept) > 0.97 * len(surface)


def test_surface_at_grazing_angle_is_kept():
    rng = np.random.default_rng(0)
    u = rng.uniform(-0.04, 0.04, (500, 2))
    front = np.column_stack([u, np.full(500, 0.6)])
    # A wall along the viewing direction has a tenth of the points per area.
    wall = np.column_stack(
        [0.04 + 1e-3 * rng.random(50), rng.uniform(-0.04, 0.04, 50), rng.uniform(0.6, 0.68, 50)]
    )
    cloud = np.vstack([front, wall])
    kept_with_view = rows(remove_outliers(cloud, VIEW).points) & rows(wall)
    kept_without_view = rows(remove_outliers(cloud, None).points) & rows(wall)
    assert len(kept_with_view) > len(kept_without_view)
    assert len(kept_with_view) >= 40


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("step", [3, 5])
def test_image_grid_and_pitch_are_detected(seed, step):
    result = remove_outliers(image_cloud(np.random.default_rng(seed), step), VIEW)
    assert result.on_grid
    pixel = step * 0.56 / FOCAL
    assert 0.9 * pixel < result.pitch < 1.3 * pixel


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("count", [100, 600, 2000])
def test_random_points_are_no_grid(seed, count):
    assert not remove_outliers(random_cloud(np.random.default_rng(seed), count), VIEW).on_grid


def test_duplicate_points_are_merged():
    cloud = random_cloud(np.random.default_rng(1), 300)
    kept = remove_outliers(np.vstack([cloud, np.repeat(cloud[:1], 900, axis=0)]), VIEW).points
    assert len(rows(kept)) == len(kept)
    assert len(kept) > 280


@pytest.mark.parametrize("count", [1, 2, 5])
def test_small_clouds_are_accepted(count):
    assert len(remove_outliers(np.eye(5, 3)[:count], None).points) >= 1

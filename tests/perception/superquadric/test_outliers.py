"""Points without neighbours go, the others stay, however the cloud lies or is listed."""

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
    """A ball in front of a camera, every `step`-th pixel, with noise in depth."""
    centre, radius = np.array([0.02, -0.01, 0.6]), 0.05
    u, v = np.meshgrid(np.arange(-90, 130, step), np.arange(-110, 110, step))
    rays = np.column_stack([u.ravel() / FOCAL, v.ravel() / FOCAL, np.ones(u.size)])
    square, along = np.sum(rays**2, axis=1), rays @ centre
    root = along**2 - square * (centre @ centre - radius**2)
    depth = (along[root > 0] - np.sqrt(root[root > 0])) / square[root > 0]
    return rays[root > 0] * (depth + noise * rng.normal(size=depth.size))[:, None]


def drawn_cloud(rng, count=600) -> np.ndarray:
    """One side of the same ball, points anywhere."""
    pose = RigidTransform.from_translation([0.02, -0.01, 0.6])
    ball = Superquadric(np.full(3, 0.05), (1.0, 1.0), pose)
    points = sample_surface(ball, 3 * count, rng)
    points = points[np.einsum("ij,ij->i", -points, ball.normals(points)) > 0][:count]
    return points + 0.001 * rng.normal(size=points.shape)


def rows(cloud: np.ndarray) -> set[tuple[float, ...]]:
    return {tuple(point) for point in cloud.tolist()}


@given(seed=seeds)
@settings(max_examples=20)
def test_who_stays_depends_on_neither_order_nor_frame(seed):
    rng = np.random.default_rng(seed)
    cloud = np.vstack([drawn_cloud(rng), rng.uniform([-0.3, -0.3, 0.3], [0.3, 0.3, 0.9], (60, 3))])
    here = remove_outliers(cloud, VIEW)
    order = rng.permutation(len(cloud))
    listed = remove_outliers(cloud[order], VIEW)
    assert rows(listed.points) == rows(here.points)
    assert listed.pitch == pytest.approx(here.pitch, rel=1e-9)
    T = RigidTransform.from_components(rng.normal(size=3), Rotation.random(rng=rng))
    there = remove_outliers(T.apply(cloud), T.apply(VIEW))
    assert len(there.points) == len(here.points)
    assert np.allclose(there.points, T.apply(here.points), atol=1e-12)
    assert there.pitch == pytest.approx(here.pitch, rel=1e-9)
    assert there.on_grid == here.on_grid


@pytest.mark.parametrize("view", [None, VIEW])
def test_lone_points_go_and_the_surface_stays(view):
    rng = np.random.default_rng(0)
    surface = drawn_cloud(rng)
    lone = rng.uniform([-0.4, -0.4, 0.2], [0.4, 0.4, 1.0], (80, 3))
    lone = lone[np.abs(np.linalg.norm(lone - [0.02, -0.01, 0.6], axis=1) - 0.05) > 0.03]
    kept = rows(remove_outliers(np.vstack([surface, lone]), view).points)
    assert not kept & rows(lone)
    assert len(kept) > 0.97 * len(surface)


def test_a_surface_seen_at_a_grazing_angle_stays():
    rng = np.random.default_rng(0)
    u = rng.uniform(-0.04, 0.04, (500, 2))
    facing = np.column_stack([u, np.full(500, 0.6)])
    # A wall in depth: the same pixels hold a tenth of the points per area.
    wall = np.column_stack(
        [0.04 + 1e-3 * rng.random(50), rng.uniform(-0.04, 0.04, 50), rng.uniform(0.6, 0.68, 50)]
    )
    cloud = np.vstack([facing, wall])
    seen = rows(remove_outliers(cloud, VIEW).points) & rows(wall)
    blind = rows(remove_outliers(cloud, None).points) & rows(wall)
    assert len(seen) > len(blind)
    assert len(seen) >= 40


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("step", [3, 5])
def test_the_grid_of_an_image_is_recognised_with_its_pitch(seed, step):
    near = remove_outliers(image_cloud(np.random.default_rng(seed), step), VIEW)
    assert near.on_grid
    pixel = step * 0.56 / FOCAL
    assert 0.9 * pixel < near.pitch < 1.3 * pixel


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("count", [100, 600, 2000])
def test_points_drawn_at_random_are_no_grid(seed, count):
    assert not remove_outliers(drawn_cloud(np.random.default_rng(seed), count), VIEW).on_grid


def test_many_copies_of_one_point_count_once():
    cloud = drawn_cloud(np.random.default_rng(1), 300)
    kept = remove_outliers(np.vstack([cloud, np.repeat(cloud[:1], 900, axis=0)]), VIEW).points
    assert len(rows(kept)) == len(kept)
    assert len(kept) > 280


@pytest.mark.parametrize("count", [1, 2, 5])
def test_clouds_smaller_than_a_neighbourhood_come_through(count):
    assert len(remove_outliers(np.eye(5, 3)[:count], None).points) >= 1

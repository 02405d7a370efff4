"""Tests of the compiled steps of the search for parts against NumPy."""

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from eyehand.perception import perpendicular_pair
from eyehand.perception.superquadric.free_space_kernels import covers_free_space, rays_through_box
from eyehand.perception.superquadric.parameters import ShapeParameters
from eyehand.perception.superquadric.part_kernels import hides_places, seam_share, vote_parts

ORIGIN = np.array([0.2, -0.1, 4.0])


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def test_votes_and_seam(rng):
    gaps = rng.normal(size=(3, 200))
    neighbours = rng.integers(0, 200, (200, 8))
    nearest = np.eye(3)[np.abs(gaps).argmin(axis=0)]
    labels = (nearest + nearest[neighbours].sum(axis=1)).argmax(axis=1)
    assert np.array_equal(vote_parts(gaps, neighbours), labels)
    differs = (labels[neighbours] != labels[:, None]).any(axis=1)
    assert seam_share(labels, neighbours) == pytest.approx(differs.mean())


def test_hidden_places(rng):
    forward = -ORIGIN / np.linalg.norm(ORIGIN)
    frame = np.vstack([perpendicular_pair(forward), forward])
    points = rng.uniform(-1.0, 1.0, (300, 3)) * [1.0, 1.0, 0.05]
    local = (points - ORIGIN) @ frame.T
    image = local[:, :2] / local[:, 2:]
    mask = points[:, 0] > 0.0
    answers = set()
    for _ in range(60):
        place = rng.uniform(-1.5, 1.5, (1, 3))
        own = (place - ORIGIN) @ frame.T
        gap, nearest = KDTree(image).query(own[0, :2] / own[0, 2])
        behind = np.linalg.norm(place[0] - ORIGIN) > np.linalg.norm(points[nearest] - ORIGIN)
        expected = bool(behind and mask[nearest] and gap < 0.02)
        assert hides_places(place, points, image, mask, frame, ORIGIN, 0.02) == expected
        answers.add(expected)
    assert answers == {True, False}


@pytest.mark.parametrize("taper", [0.0, 0.6])
def test_rays_beside_the_box_miss_the_solid(taper, rng):
    shape = ShapeParameters(
        np.log([0.5, 0.2, 0.9]),
        np.array([0.3, 1.2]),
        Rotation.random(rng=rng).as_matrix(),
        np.array([0.1, 0.2, -0.1]),
        np.array([taper, -taper]),
    )
    targets = rng.uniform(-1.5, 1.5, (2000, 3))
    rays = (targets - ORIGIN) / np.linalg.norm(targets - ORIGIN, axis=1, keepdims=True)
    near = rays_through_box(rays, ORIGIN, shape)
    half = np.exp(shape.log_axes) * [1.0 + taper, 1.0 + taper, 1.0]
    origin, slopes = (ORIGIN - shape.centre) @ shape.R, rays @ shape.R
    sides = np.sort([(-half - origin) / slopes, (half - origin) / slopes], axis=0)
    meets = np.maximum(sides[0].max(axis=1), 0.0) <= sides[1].min(axis=1)
    assert np.array_equal(near, np.flatnonzero(meets))
    states = covers_free_space(rays, np.full(len(rays), 100.0), ORIGIN, shape)
    assert set(np.flatnonzero(states)) <= set(near)
    assert 50 < np.count_nonzero(states) < len(near)

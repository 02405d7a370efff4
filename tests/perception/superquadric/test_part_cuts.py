"""Tests of the proposals to cut a cloud in two."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.perception import Superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.part_cuts import (
    hull_area_sums,
    image_cuts,
    largest_cluster,
    propose_cuts,
)


def hull_area(points: np.ndarray) -> float:
    return cv2.contourArea(cv2.convexHull(points.astype(np.float32))) if len(points) > 2 else 0.0


@pytest.mark.parametrize("seed", range(5))
def test_hull_areas_equal_those_of_each_side(seed):
    points = np.random.default_rng(seed).normal(size=(60, 2))
    points = points[np.argsort(points[:, 0])]
    sums = hull_area_sums(points[:, 0].copy(), points[:, 1].copy())
    reference = [hull_area(points[:k]) + hull_area(points[k:]) for k in range(1, 60)]
    assert sums == pytest.approx(reference, abs=1e-5)


def test_best_cut_of_two_disks_lies_at_the_neck():
    rng = np.random.default_rng(0)
    disk = rng.uniform(-1.0, 1.0, (800, 2))
    disk = disk[np.linalg.norm(disk, axis=1) < 1.0]
    second = np.arange(len(disk)) % 2 == 0
    image = disk + np.where(second[:, None], [1.9, 0.0], [0.0, 0.0])
    cut = image_cuts(image, 3, 25)[0]
    agreement = np.mean(cut == second)
    assert max(agreement, 1.0 - agreement) > 0.97


def test_proposed_cuts_are_balanced_and_different():
    rng = np.random.default_rng(0)
    solid = Superquadric(np.array([0.05, 0.03, 0.02]), (0.5, 0.5), RigidTransform.identity())
    points = sample_surface(solid, 300, rng)
    neighbours = np.argsort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, 1:9]
    residuals = np.where(points[:, 0] > 0.03, 0.01, 0.0)
    for image in (None, points[:, :2]):
        cuts = propose_cuts(points, image, neighbours, residuals, 0.001, 25)
        assert any(np.array_equal(mask, points[:, 0] > 0.03) for mask in cuts)
        for mask in cuts:
            assert 25 <= np.count_nonzero(mask) <= 275
        for k, one in enumerate(cuts):
            for other in cuts[:k]:
                count_different = np.count_nonzero(one ^ other)
                assert min(count_different, 300 - count_different) > 12


def test_largest_cluster_is_connected():
    line = np.arange(20)
    neighbours = np.column_stack([line - 1, np.where(line < 19, line + 1, -1)])
    selected = np.isin(line, [1, 2, 3, 7, 8, 9, 10, 15])
    cluster = largest_cluster(selected, neighbours)
    assert np.array_equal(np.flatnonzero(cluster), [7, 8, 9, 10])
    assert not largest_cluster(np.zeros(20, dtype=bool), neighbours).any()

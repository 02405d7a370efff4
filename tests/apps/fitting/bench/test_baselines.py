"""The published baselines reach the accuracy that they should have."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench.baselines import BASELINES, find_baseline
from eyehand.apps.fitting.bench.clouds import fit_case
from eyehand.apps.fitting.bench.ems import ems_fit, gauge_at, radial_distances
from eyehand.apps.fitting.bench.score import overlap
from eyehand.apps.fitting.bench.stress_views import usual_solid
from eyehand.perception import Superquadric
from eyehand.perception.superquadric import sample_surface


def test_exact_surfaces_are_recovered():
    met = []
    for seed in range(6):
        solid, _ = usual_solid(seed)
        points = sample_surface(solid, 500, np.random.default_rng([seed, 99]))
        found = ems_fit(points, None, None)
        assert found is not None
        met.append(overlap(solid, [found]))
    assert np.median(met) > 0.99
    assert min(met) > 0.9


def test_outliers_are_rejected():
    case = fit_case("full-outliers", 3)
    found = ems_fit(case.points)
    assert found is not None
    assert overlap(case.truth, [found]) > 0.99


def test_moved_and_scaled_cloud_is_recovered():
    solid, _ = usual_solid(3)
    points = sample_surface(solid, 300, np.random.default_rng(0))
    T = RigidTransform.from_components([20.0, -5.0, 8.0], Rotation.from_rotvec([1.0, 0.4, -2.0]))
    found = ems_fit(T.apply(50.0 * points), None, None)
    there = Superquadric(
        50 * solid.semi_axes,
        solid.exponents,
        T * RigidTransform.from_components(50 * solid.centre, solid.pose.rotation),
    )
    assert found is not None
    assert overlap(there, [found]) > 0.98


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((0, 3)),
        np.random.default_rng(0).normal(size=(10, 3)),
        np.full((50, 3), np.nan),
        np.ones((50, 3)),
    ],
)
def test_too_few_or_invalid_points_give_none(points):
    assert ems_fit(points, None, None) is None


def test_flat_and_straight_clouds_do_not_raise():
    rng = np.random.default_rng(0)
    for extents in ([0.05, 0.05, 0.0], [0.05, 0.0, 0.0]):
        found = ems_fit(rng.normal(size=(100, 3)) * extents, None, None)
        assert found is None or np.all(np.isfinite(found.pose.as_matrix()))


def test_gauge_and_radial_distance_are_those_of_the_solid():
    solid, _ = usual_solid(5)
    frame = Rotation.from_rotvec([0.3, -0.2, 0.9])
    vector = (frame.inv() * solid.pose.rotation).as_rotvec()
    x = np.concatenate([solid.exponents, solid.semi_axes, vector, solid.centre])
    points = solid.centre + np.random.default_rng(0).normal(size=(200, 3)) * 0.05
    assert gauge_at(points, x, frame.as_matrix()) == pytest.approx(
        solid.radial_scale(points), rel=1e-9
    )
    along = np.linalg.norm(points - solid.project_radially(points), axis=1)
    distances = radial_distances(points, x, frame.as_matrix())
    assert np.abs(distances) == pytest.approx(along, abs=1e-12)
    assert np.array_equal(distances < 0, solid.contains(points))


def test_baselines_are_found_by_name():
    assert {find_baseline(name) for name in BASELINES} == {ems_fit}

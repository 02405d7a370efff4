"""Tests of the reasons for which a cloud or a fit is rejected."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import sample_surface
from eyehand.perception.superquadric.outliers import remove_outliers
from eyehand.perception.superquadric.parameters import ShapeParameters
from eyehand.perception.superquadric.problem import FitProblem, Observation, build_problem
from eyehand.perception.superquadric.validity import (
    MAX_EXTENT_RATIO,
    MAX_SPREAD_NOISE,
    check_cloud,
    check_extent,
    check_residuals,
    check_size,
)

OPTIONS = FitOptions()
FLOOR = np.array([0.0, 0.0, 1.0, 0.0])


def ball(count=400, radius=0.04, seed=0) -> np.ndarray:
    solid = Superquadric(np.full(3, radius), (1.0, 1.0), RigidTransform.identity())
    return sample_surface(solid, count, np.random.default_rng(seed))


def scattered(scale, seed=0, count=300) -> np.ndarray:
    """Return normally distributed points (count, 3)."""
    return np.random.default_rng(seed).normal(size=(count, 3)) * scale


def make_problem(cloud=None) -> FitProblem:
    cloud = ball() if cloud is None else cloud
    return build_problem(Observation(remove_outliers(cloud, None)), OPTIONS)


@pytest.mark.parametrize(
    ("cloud", "origin", "message"),
    [
        (scattered(0.05, count=49), None, "49 points are too few: at least 50"),
        (np.vstack([ball(), [[np.nan, 0, 0], [0, np.inf, 0]]]), None, "2 points are NaN"),
        (ball(radius=3e6), None, "coordinates reach 2.99e+06 m"),
        (ball(), np.array([0.0, 0.0, 2e9]), "the camera is 2e+09 m away"),
    ],
)
def test_invalid_coordinates_are_rejected(cloud, origin, message):
    assert message in check_cloud(cloud, origin)
    assert check_cloud(ball(), np.array([0.0, 0.0, 0.7])) == ""


@pytest.mark.parametrize(
    ("cloud", "origin", "plane", "message"),
    [
        (np.ones((80, 3)), None, None, "all points are the same point"),
        (scattered(40.0), None, None, "are these metres"),
        (scattered(1e-5), None, None, "are these metres"),
        (scattered([0.05, 0.0, 0.0]), None, None, "all points lie on one line"),
        (scattered([0.05, 0.05, 0.0]), None, None, "lie on one plane: give the support plane"),
        (ball(30), None, None, "30 different points are too few"),
        (ball(), ball()[7] + 1e-4, None, "a point lies at the camera"),
        (ball(), None, np.array([0.0, 0.0, 1.0, 5.0]), "the support plane passes 5 m"),
        (ball(), None, np.array([0.0, 0.0, 1.0, -0.1]), "mm under the support plane"),
        (scattered([0.05, 0.05, 0.001]), None, FLOOR, "lie in the support plane: nothing rises"),
    ],
)
def test_degenerate_clouds_are_rejected(cloud, origin, plane, message):
    assert message in check_extent(cloud, origin, plane, OPTIONS)


def test_valid_clouds_are_accepted():
    plane = np.array([0.0, 0.0, 1.0, 0.04])
    assert check_extent(ball(), np.array([0.0, 0.0, 0.7]), plane, OPTIONS) == ""
    top = scattered([0.05, 0.05, 0.0]) + np.array([0.0, 0.0, 0.05])
    assert check_extent(top, None, FLOOR, OPTIONS) == ""


@pytest.mark.parametrize("noise", [0.0005, 0.001])
@pytest.mark.parametrize("seed", range(4))
def test_noisy_sheet_and_wire_are_rejected(noise, seed):
    rng = np.random.default_rng(seed)
    R = Rotation.random(rng=rng).as_matrix()
    flat = rng.uniform(-0.06, 0.06, (500, 3)) * [1.0, 0.8, 0.0]
    wire = rng.uniform(-0.06, 0.06, (500, 3)) * [1.0, 0.0, 0.0]
    for cloud, message in ((flat, "on one plane"), (wire, "on one line")):
        fit = fit_superquadric((cloud + noise * rng.normal(size=cloud.shape)) @ R.T)
        assert not fit
        assert message in fit.reason
        assert fit.superquadric is None
        assert fit.uncertainty is None


@pytest.mark.parametrize("seed", range(4))
def test_slightly_curved_surface_is_accepted(seed):
    rng = np.random.default_rng(seed)
    points = ball(3000, 0.06, seed)
    cap = points[points[:, 2] > 0.03][:500]
    cap += 0.0005 * rng.normal(size=cap.shape)
    assert fit_superquadric(cap, view_origin=[0.0, 0.0, 0.8])


@pytest.mark.parametrize(
    ("origin", "message"),
    [
        (ball()[3] + 1e-5, "a point lies at the camera"),
        ([0.0, 0.0, 0.0], "the camera would stand inside the solid"),
        ([0.0, 0.0, 0.03], "the camera would stand inside the solid"),
    ],
)
def test_camera_at_point_or_inside_solid_is_rejected(origin, message):
    fit = fit_superquadric(ball(), view_origin=origin)
    assert not fit
    assert message in fit.reason


def test_points_below_support_plane_are_rejected():
    fit = fit_superquadric(ball() - [0.0, 0.0, 0.1], support_plane=FLOOR)
    assert not fit
    assert "under the support plane" in fit.reason


def test_large_residuals_are_rejected():
    unit = 0.05
    limit = max(MAX_SPREAD_NOISE * OPTIONS.noise, 0.12 * unit)
    assert check_residuals(scattered(0.001)[:, 0], unit, OPTIONS) == ""
    assert "points spread" in check_residuals(scattered(2.0 * limit)[:, 0], unit, OPTIONS)
    residuals = np.where(np.arange(300) < 120, 5.0 * limit, 0.0)
    assert "40 % of the points lie more than" in check_residuals(residuals, unit, OPTIONS)


def test_unsupported_sizes_are_rejected():
    problem = make_problem()
    extent = float(np.linalg.norm(problem.points, axis=1).max())

    def reason(*semi_axes):
        axes = np.log(np.array(semi_axes))
        return check_size(
            ShapeParameters(axes, np.ones(2), np.eye(3), np.zeros(3)), problem, OPTIONS
        )

    assert reason(1.0, 1.0, 1.0) == ""
    assert "grew to over 4 times what was seen" in reason(
        1.0, 1.01 * MAX_EXTENT_RATIO * extent, 1.0
    )
    low, high = np.array(OPTIONS.axis_range) / problem.unit
    assert "shrank to its bound of 0.002 m" in reason(1.0, low, 1.0)
    large = make_problem(ball(radius=0.5))
    bound = np.log(np.full(3, OPTIONS.axis_range[1] / large.unit))
    reason_of_large = check_size(
        ShapeParameters(bound, np.ones(2), np.eye(3), np.zeros(3)), large, OPTIONS
    )
    assert "grew to its bound of 1.0 m" in reason_of_large
    assert high > MAX_EXTENT_RATIO * extent


def test_rejected_fit_is_false_and_empty():
    fit = fit_superquadric(np.ones((80, 3)))
    assert not fit
    assert not fit.converged
    assert fit.candidates == ()
    assert fit.parts == ()
    assert fit.residuals.size == 0
    assert fit.runner_up is None
    assert fit.margin == np.inf
    assert not fit.ambiguous
    assert fit.spread == np.inf
    assert fit.seconds > 0.0

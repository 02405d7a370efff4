"""Tests of the refinement under the constraint of seen free space."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, FreeSpace, Superquadric
from eyehand.perception.superquadric import covered_share, sample_surface
from eyehand.perception.superquadric.constrained import (
    ray_depths,
    refine_in_free_space,
    whitened_ray_depths,
)
from eyehand.perception.superquadric.cost_kernels import normal_equations
from eyehand.perception.superquadric.kinds import basis
from eyehand.perception.superquadric.levenberg_marquardt import (
    add_prior,
    apply_step,
    levenberg_marquardt,
)
from eyehand.perception.superquadric.outliers import remove_outliers
from eyehand.perception.superquadric.parameters import N_PARAMETERS, N_STRAIGHT, ShapeParameters
from eyehand.perception.superquadric.problem import Observation, build_problem, parameter_bounds

OPTIONS = FitOptions()
TOLERANCE = 0.002
WIDE_BOUNDS = np.array([[-5.0, 5.0], [0.02, 1.98], [-0.9, 0.9]])
seeds = st.integers(0, 2**31 - 1)


def random_rays(rng):
    """Return a tapered solid and rays from 5 above that pass near it, with depths."""
    shape = ShapeParameters(
        np.log(rng.uniform(0.6, 1.4, 3)),
        rng.uniform(0.4, 1.0, 2),
        Rotation.random(rng=rng).as_matrix(),
        rng.normal(size=3),
        rng.uniform(-0.3, 0.3, 2),
    )
    origin = shape.centre + np.array([0.0, 0.0, 5.0])
    rays = shape.centre + 0.8 * rng.normal(size=(8, 3)) - origin
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return shape, rays, rng.uniform(3.5, 6.5, 8), origin


def radial_scale(shape, points):
    solid = Superquadric(
        np.exp(shape.log_axes),
        tuple(shape.exponents),
        RigidTransform.from_components(shape.centre, Rotation.from_matrix(shape.R)),
        "tapered",
        tuple(shape.taper),
    )
    return solid.radial_scale(points)


@given(seed=seeds)
def test_depths_equal_the_smallest_scale_before_the_reading(seed):
    shape, rays, depth, origin = random_rays(np.random.default_rng(seed))
    values, rows = np.empty(8), np.empty((8, N_PARAMETERS))
    ray_depths(rays, depth, origin, shape, True, values, rows)
    for ray, limit, value in zip(rays, depth, values, strict=True):
        along = np.append(np.linspace(2.0, limit, 1500), limit)
        lowest = radial_scale(shape, origin + along[:, None] * ray).min()
        expected = np.exp(shape.log_axes.min()) * (1.0 - lowest)
        assert value <= expected + 1e-3
        # Farther outside, a tapered solid can have several minima along a ray.
        if expected > -0.2:
            assert value == pytest.approx(expected, abs=1e-3)


@given(seed=seeds, distance=st.sampled_from([0.0, 0.1]))
def test_gradients_match_finite_differences(seed, distance):
    rng = np.random.default_rng(seed)
    start, rays, depth, origin = random_rays(rng)
    # A tapered solid can have several minima along a ray.
    start = start._replace(taper=np.zeros(2))
    unwhiten, y = 0.3 * rng.normal(size=(N_PARAMETERS, 5)), distance * rng.normal(size=5)
    unwhiten[[2, 3, 4]] *= 0.1
    unwhiten[[11, 12]] = 0.0

    def at(y):
        return whitened_ray_depths(y, unwhiten, rays, depth, origin, start, False, WIDE_BOUNDS)

    h = 1e-6
    numeric = np.transpose([(at(y + h * d)[0] - at(y - h * d)[0]) / (2 * h) for d in np.eye(5)])
    values, gradients = at(y)
    assert gradients.shape == (8, 5)
    near = np.abs(values) < 0.5
    assert np.allclose(gradients[near], numeric[near], rtol=1e-3, atol=2e-3)


def half_ball(rng):
    """Return a ball, the points of it that a camera at the origin sees, and their free space."""
    ball = Superquadric(np.full(3, 0.05), (1.0, 1.0), RigidTransform.from_translation([0, 0, 0.7]))
    points = sample_surface(ball, 1500, rng)
    points = points[np.einsum("ij,ij->i", ball.normals(points), points) < 0]
    points += 0.001 * rng.normal(size=points.shape)
    steps = np.linspace(-0.12, 0.12, 35)
    across = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    rays = np.column_stack([across, np.ones(len(across))])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    along = rays @ ball.centre
    miss = np.sqrt(np.maximum(np.sum(ball.centre**2) - along**2, 0.0))
    on_object = miss < 0.05
    surface = along - np.sqrt(np.maximum(0.05**2 - miss**2, 0.0))
    depth = np.where(on_object, surface, 0.9)
    return ball, points, FreeSpace(np.zeros(3), rays, depth, on_object, steps[1] - steps[0])


def fit_problem(points):
    options = replace(OPTIONS, silhouette_rays=0)
    filtered = remove_outliers(points, np.zeros(3))
    return build_problem(Observation(filtered, np.zeros(3)), options)


def moved_ball(problem, factor, shift):
    return ShapeParameters(
        np.log(np.full(3, factor * 0.05 / problem.unit)),
        np.ones(2),
        np.eye(3),
        (np.array([shift, 0.0, 0.7]) - problem.centre) / problem.unit,
    )


def solid_of(problem, shape):
    centre = shape.centre * problem.unit + problem.centre
    pose = RigidTransform.from_components(centre, Rotation.from_matrix(shape.R))
    return Superquadric(np.exp(shape.log_axes) * problem.unit, tuple(shape.exponents), pose)


@pytest.mark.parametrize("factor", [1.1, 1.3])
@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_solid_is_moved_out_of_free_space(factor, shift):
    _, points, free_space = half_ball(np.random.default_rng(1))
    problem = fit_problem(points)
    start = moved_ball(problem, factor, shift)
    assert covered_share([solid_of(problem, start)], free_space, TOLERANCE) > 0.2
    shape = refine_in_free_space(problem, start, "superquadric", free_space, TOLERANCE, OPTIONS)
    solid = solid_of(problem, shape)
    assert covered_share([solid], free_space, TOLERANCE) < 0.02
    assert np.median(np.abs(solid.distance(points))) < 0.0015


def test_solid_outside_free_space_is_not_changed():
    _, points, free_space = half_ball(np.random.default_rng(2))
    problem = fit_problem(points)
    start = moved_ball(problem, 0.9, 0.0)
    far = replace(free_space, depth=np.full(len(free_space.rays), 0.5))
    shape = refine_in_free_space(problem, start, "superquadric", far, TOLERANCE, OPTIONS)
    assert all(np.array_equal(a, b) for a, b in zip(shape, start, strict=True))


def test_nan_problem_returns_start():
    _, points, free_space = half_ball(np.random.default_rng(3))
    problem = fit_problem(points)
    terms = problem.terms._replace(points=np.full_like(problem.points, np.nan))
    start = moved_ball(problem, 1.3, 0.0)
    shape = refine_in_free_space(
        replace(problem, terms=terms), start, "superquadric", free_space, TOLERANCE, OPTIONS
    )
    assert all(np.array_equal(a, b) for a, b in zip(shape, start, strict=True))


@pytest.mark.parametrize("seed", range(4))
def test_last_descent_ends_where_powell_ends(seed):
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_components([0.0, 0.0, 0.7], Rotation.random(rng=rng))
    e1, e2 = rng.choice([0.3, 0.5, 1.0, 1.5], 2)
    solid = Superquadric(rng.uniform(0.02, 0.07, 3), (float(e1), float(e2)), pose)
    points = sample_surface(solid, 1600, rng)
    points = points[np.einsum("ij,ij->i", solid.normals(points), points) < 0][:400]
    problem = fit_problem(points + 0.001 * rng.normal(size=points.shape))
    guess = ShapeParameters(
        np.log(solid.semi_axes / problem.unit),
        np.array(solid.exponents),
        solid.rotation,
        (solid.centre - problem.centre) / problem.unit,
    )
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    end, _, _ = levenberg_marquardt(problem, guess, basis("superquadric"), bounds, 60)

    def value(step):
        shape = apply_step(end, np.append(step, [0.0, 0.0]), bounds)
        cost, gradient, hessian = normal_equations(problem.terms, shape, False)
        return float(cost) + add_prior(problem.prior, shape, gradient, hessian)

    low, high = np.full(N_STRAIGHT, -np.inf), np.full(N_STRAIGHT, np.inf)
    low[3:5], high[3:5] = bounds[1, 0] - end.exponents, bounds[1, 1] - end.exponents
    limits = list(zip(low, high, strict=True))
    powell = minimize(value, np.zeros(N_STRAIGHT), method="Powell", bounds=limits)
    assert powell.fun > 0.995 * value(np.zeros(N_STRAIGHT))

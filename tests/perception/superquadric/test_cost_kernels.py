"""Tests of cost kernels: residuals equal NumPy, and derivatives equal finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception.superquadric import Superquadric
from eyehand.perception.superquadric.cost_kernels import distances, normal_equations
from eyehand.perception.superquadric.parameters import (
    N_PARAMETERS,
    N_STRAIGHT,
    CostTerms,
    ShapeParameters,
)
from eyehand.perception.superquadric.point_kernels import compute_distance_rows
from eyehand.perception.superquadric.work_rows import LANES, RESIDUAL, new_workspace

seeds = st.integers(0, 2**31 - 1)


def random_state(rng, low=0.1, high=1.9, tapered=False):
    axes = np.log(rng.uniform(0.5, 1.5, 3))
    taper = rng.uniform(-0.5, 0.5, 2) if tapered else np.zeros(2)
    R = Rotation.random(rng=rng).as_matrix()
    return ShapeParameters(axes, rng.uniform(low, high, 2), R, rng.normal(size=3), taper)


def step_state(state, step):
    axes, eps, R, c, taper = state
    rotation = Rotation.from_rotvec(step[5:8]).as_matrix()
    return ShapeParameters(
        axes + step[:3], eps + step[3:5], R @ rotation, c + R @ step[8:11], taper + step[11:]
    )


def point_row(point, state, tapered):
    """Return the residual of one point and its derivatives."""
    work = new_workspace()
    work.flat[:] = np.nan
    compute_distance_rows(np.array([point]), 0, 1, state, tapered, work)
    return work.flat[RESIDUAL], work.grid[:N_PARAMETERS, 0].copy()


@given(seed=seeds, tapered=st.booleans())
def test_distances_equal_numpy(seed, tapered):
    rng = np.random.default_rng(seed)
    state = random_state(rng, tapered=tapered)
    axes, eps, R, c, taper = state
    pose = RigidTransform.from_components(c, Rotation.from_matrix(R))
    solid = Superquadric(np.exp(axes), (eps[0], eps[1]), pose, "tapered", (taper[0], taper[1]))
    points = c + rng.normal(size=(rng.integers(1, 3 * LANES), 3))
    reference = solid.distance(points)
    assert np.allclose(distances(points, state), reference, rtol=1e-9, atol=1e-10)


@given(seed=seeds, tapered=st.booleans())
def test_residual_derivatives_match_finite_differences(seed, tapered):
    rng = np.random.default_rng(seed)
    state = random_state(rng, tapered=tapered)
    # The taper is clamped beyond 1.05 a3, outside the solid. This gives a kink there.
    local = rng.uniform(0.3, [1.2, 1.2, np.exp(state[0][2])]) * rng.choice([-1, 1], 3)
    point = state[3] + state[2] @ local
    _, exact = point_row(point, state, tapered)
    h = 1e-5

    def distance_at(step):
        return distances(point[None], step_state(state, step))[0]

    # Second-order differences do not reach the tolerance of 1e-8.
    n_free = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [
        (
            8 * (distance_at(h * d) - distance_at(-h * d))
            - (distance_at(2 * h * d) - distance_at(-2 * h * d))
        )
        / (12 * h)
        for d in np.eye(N_PARAMETERS)[:n_free]
    ]
    assert np.allclose(exact[:n_free], numeric, rtol=1e-7, atol=1e-8)


@given(seed=seeds, tapered=st.booleans(), outside_weight=st.sampled_from([0.0, 0.4]))
@settings(max_examples=60)
def test_gradient_with_rays_and_plane_matches_finite_differences(seed, tapered, outside_weight):
    rng = np.random.default_rng(seed)
    # Above ε = 1 solids have ridges. There the slope along a ray changes within rounding error.
    state = random_state(rng, 0.3, 1.0, tapered)
    _, _, R, c, _ = state
    points = c + (rng.uniform(0.4, 1.0, (40, 3)) * rng.choice([-1, 1], (40, 3))) @ R.T
    points = points[np.abs((points - c) @ R[:, 2]) < 1.04 * np.exp(state[0][2])]
    weights = np.full(len(points), 1 / len(points))
    origin = c + np.array([0.0, 0.0, 5.0])
    # Rays that miss evaluate the gauge outside, where the clamped taper has a kink.
    outside_weight = 0.0 if tapered else outside_weight
    targets = c + rng.normal(size=(12, 3)) * 0.5
    # On a ray through the centre the gauge has a kink, as |x| has at 0.
    targets = targets[np.linalg.norm((targets - c)[:, :2], axis=1) > 0.2]
    rays = (targets - origin) / np.linalg.norm(targets - origin, axis=1, keepdims=True)
    plane = np.array([0.0, 0.0, 1.0, 0.8 - c[2]])

    normals = rng.normal(size=(6, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    outline = np.column_stack([normals, rng.uniform(0.5, 1.5, 6) - normals @ c])
    terms = CostTerms(
        points, weights, rays, origin, plane, 0.1, 0.7, outside_weight, 0.5, 0.3, outline, 0.4
    )

    def cost(step):
        return normal_equations(terms, step_state(state, step), tapered)

    h = 1e-6
    n_free = N_PARAMETERS if tapered else N_STRAIGHT
    numeric = [(cost(h * d)[0] - cost(-h * d)[0]) / (2 * h) for d in np.eye(N_PARAMETERS)[:n_free]]
    value, gradient, hessian = cost(np.zeros(N_PARAMETERS))
    assert value >= 0
    assert np.allclose(gradient[:n_free], numeric, atol=2e-6)
    assert np.allclose(gradient[n_free:], 0.0)
    assert np.allclose(hessian, hessian.T)
    assert np.linalg.eigvalsh(hessian).min() > -1e-9 * np.abs(hessian).max()


@pytest.mark.parametrize("e", [0.02, 0.1, 1.0, 1.9, 1.98])
def test_residuals_are_finite_at_centre_and_far_away(e):
    state = ShapeParameters(np.zeros(3), np.array([e, e]), np.eye(3), np.zeros(3), np.full(2, 0.9))
    for point in ([0.0, 0.0, 0.0], [1e6, 1e6, 1e6], [1.0, 0.0, 0.0], [1e-12, 1.0, 1e-12]):
        distance, row = point_row(point, state, tapered=True)
        assert np.isfinite(distance)
        assert np.all(np.isfinite(row))


@given(seed=seeds, count=st.integers(1, 3 * LANES), tapered=st.booleans())
def test_cost_gradient_and_hessian_equal_sums_over_points(seed, count, tapered):
    rng = np.random.default_rng(seed)
    state = random_state(rng, tapered=tapered)
    points, weights, scale = state[3] + rng.normal(size=(count, 3)), rng.random(count), 0.1
    no_rays = np.zeros((0, 3))
    plane = np.array([0.0, 0.0, 1.0, 0.0])
    terms = CostTerms(points, weights, no_rays, np.zeros(3), plane, scale, 0.0, 0.0, 0.0, 1.0)
    cost, gradient, hessian = normal_equations(terms, state, tapered)
    n_free = N_PARAMETERS if tapered else N_STRAIGHT
    rows = [point_row(point, state, tapered) for point in points]
    r, J = np.array([row[0] for row in rows]), np.array([row[1][:n_free] for row in rows])
    slope = weights / (1.0 + (r / scale) ** 2)
    assert cost == pytest.approx(weights @ (0.5 * scale**2 * np.log1p((r / scale) ** 2)))
    assert np.allclose(gradient[:n_free], J.T @ (slope * r), rtol=1e-9, atol=1e-12)
    assert np.allclose(hessian[:n_free, :n_free], J.T @ (slope[:, None] * J), rtol=1e-9, atol=1e-12)
    assert not gradient[n_free:].any()
    assert not hessian[n_free:].any()

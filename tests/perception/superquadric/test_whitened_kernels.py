"""Tests of the whitened cost: its value at the moved start, and its gradient."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from eyehand.perception.superquadric.cost_kernels import normal_equations
from eyehand.perception.superquadric.levenberg_marquardt import add_prior, apply_step
from eyehand.perception.superquadric.parameters import (
    N_PARAMETERS,
    CostTerms,
    Prior,
    ShapeParameters,
)
from eyehand.perception.superquadric.whitened_kernels import right_jacobian, whitened_cost

seeds = st.integers(0, 2**31 - 1)
WIDE_BOUNDS = np.array([[-5.0, 5.0], [0.02, 1.98], [-0.9, 0.9]])
WEIGHTS = (0.1, 0.7, 0.0, 0.5, 0.3)


def make_terms(rng):
    """Return cost terms of points, rays and a plane for a tapered solid, and its parameters."""
    axes, eps = np.log(rng.uniform(0.6, 1.4, 3)), rng.uniform(0.4, 1.0, 2)
    R, c = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)
    taper = rng.uniform(-0.3, 0.3, 2)
    local = rng.uniform(0.4, 0.9, (30, 3)) * rng.choice([-1, 1], (30, 3))
    local[:, 2] *= np.exp(axes[2])
    origin = c + np.array([0.0, 0.0, 5.0])
    targets = c + 0.4 * rng.normal(size=(8, 3))
    targets = targets[np.linalg.norm((targets - c)[:, :2], axis=1) > 0.2]
    rays = (targets - origin) / np.linalg.norm(targets - origin, axis=1, keepdims=True)
    plane = np.array([0.0, 0.0, 1.0, 0.8 - c[2]])
    terms = CostTerms(c + local @ R.T, np.full(30, 1 / 30), rays, origin, plane, *WEIGHTS)
    return terms, ShapeParameters(axes, eps, R, c, taper)


def make_prior(rng):
    """Return a prior with ceilings below the axes."""
    ceiling = np.repeat([-0.6, np.inf], [3, 4])
    above = np.repeat([0.2, 0.0], [3, 4])
    return Prior(
        rng.normal(size=7), rng.uniform(0.0, 0.3, 7), ceiling, above, rng.uniform(0.0, 0.3)
    )


def cost_at(y, unwhiten, terms, start, prior, bounds=WIDE_BOUNDS):
    return whitened_cost(y, unwhiten, terms, prior, start, True, bounds)


@given(seed=seeds)
def test_value_is_cost_plus_prior_of_moved_start(seed):
    rng = np.random.default_rng(seed)
    terms, start = make_terms(rng)
    unwhiten, y, prior = (
        rng.normal(size=(N_PARAMETERS, 5)),
        0.05 * rng.normal(size=5),
        make_prior(rng),
    )
    total, cost, _, shape = cost_at(y, unwhiten, terms, start, prior)
    moved = apply_step(start, unwhiten @ y, WIDE_BOUNDS)
    assert all(np.allclose(a, b, atol=1e-12) for a, b in zip(shape, moved, strict=True))
    expected_cost, gradient, hessian = normal_equations(terms, moved, True)
    assert cost == pytest.approx(expected_cost, rel=1e-12)
    axes, eps, _, _, taper = moved
    added = add_prior(prior, moved, gradient, hessian)
    gaps = np.concatenate([axes, eps, taper])
    excess = np.maximum(gaps - prior.ceiling, 0.0)
    expected = 0.5 * np.sum(
        prior.weight * (gaps - prior.mean) ** 2 + prior.ceiling_weight * excess**2
    )
    small, middle, _ = np.sort(axes)
    expected += 0.5 * prior.similar_weight * (middle - small) ** 2
    assert added == pytest.approx(expected, rel=1e-9)
    assert total == pytest.approx(expected_cost + expected, rel=1e-9)


@given(seed=seeds, distance=st.sampled_from([0.0, 0.05, 0.3]))
def test_gradient_matches_finite_differences(seed, distance):
    rng = np.random.default_rng(seed)
    terms, start = make_terms(rng)
    unwhiten, y, prior = (
        0.3 * rng.normal(size=(N_PARAMETERS, 7)),
        distance * rng.normal(size=7),
        make_prior(rng),
    )
    # Small steps keep the exponents away from ridges and the points within the taper.
    unwhiten[[2, 3, 4]] *= 0.1
    h = 1e-6
    numeric = [
        (
            cost_at(y + h * d, unwhiten, terms, start, prior)[0]
            - cost_at(y - h * d, unwhiten, terms, start, prior)[0]
        )
        / (2 * h)
        for d in np.eye(7)
    ]
    assert np.allclose(cost_at(y, unwhiten, terms, start, prior)[2], numeric, atol=2e-6)


@given(seed=seeds)
def test_gradient_is_zero_for_bounded_parameters(seed):
    rng = np.random.default_rng(seed)
    terms, start = make_terms(rng)
    axes, eps, _, _, taper = start
    bounds = np.array(
        [[axes.min() - 1, axes.max() + 1], [0.02, eps.max() + 0.01], [-0.9, taper.max() + 0.01]]
    )
    y = np.zeros(N_PARAMETERS)
    bounded = [3 + int(np.argmax(eps)), 11 + int(np.argmax(taper))]
    y[bounded] = 0.1
    prior, identity = make_prior(rng), np.eye(N_PARAMETERS)
    _, _, slope, (_, new_eps, _, _, new_taper) = cost_at(y, identity, terms, start, prior, bounds)
    assert np.all(slope[bounded] == 0.0)
    assert new_eps.max() == bounds[1, 1]
    assert new_taper.max() == bounds[2, 1]
    h = 1e-6
    for k in range(N_PARAMETERS):
        d = h * np.eye(N_PARAMETERS)[k]
        up, down = (cost_at(y + s * d, identity, terms, start, prior, bounds)[0] for s in (1, -1))
        assert slope[k] == pytest.approx((up - down) / (2 * h), abs=2e-6)


@given(seed=seeds, size=st.sampled_from([1e-9, 1e-5, 0.1, 1.0, 3.0]))
def test_right_jacobian_matches_finite_differences(seed, size):
    rng = np.random.default_rng(seed)
    vector = rng.normal(size=3)
    vector *= size / np.linalg.norm(vector)
    rotation, h = Rotation.from_rotvec(vector), 1e-6
    columns = [
        (
            (rotation.inv() * Rotation.from_rotvec(vector + h * d)).as_rotvec()
            - (rotation.inv() * Rotation.from_rotvec(vector - h * d)).as_rotvec()
        )
        / (2 * h)
        for d in np.eye(3)
    ]
    assert np.allclose(right_jacobian(vector), np.transpose(columns), atol=1e-8)

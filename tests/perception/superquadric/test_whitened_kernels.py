"""The chart in which nlopt moves: the cost of the moved start, and its exact slope."""

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
WIDE = np.array([[-5.0, 5.0], [0.02, 1.98], [-0.9, 0.9]])
WEIGHTS = (0.1, 0.7, 0.0, 0.5, 0.3)


def scene(rng):
    """Cost terms of points, rays and a plane about a tapered solid, and its parameters."""
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


def prior(rng):
    """A prior with ceilings below the axes."""
    ceiling = np.repeat([-0.6, np.inf], [3, 4])
    above = np.repeat([0.2, 0.0], [3, 4])
    return Prior(rng.normal(size=7), rng.uniform(0.0, 0.3, 7), ceiling, above)


def at(y, unwhiten, terms, start, belief, bounds=WIDE):
    return whitened_cost(y, unwhiten, terms, belief, start, True, bounds)


@given(seed=seeds)
def test_the_value_is_the_cost_and_the_prior_of_the_moved_guess(seed):
    rng = np.random.default_rng(seed)
    terms, start = scene(rng)
    unwhiten, y, belief = rng.normal(size=(N_PARAMETERS, 5)), 0.05 * rng.normal(size=5), prior(rng)
    total, cost, _, shape = at(y, unwhiten, terms, start, belief)
    there = apply_step(start, unwhiten @ y, WIDE)
    assert all(np.allclose(a, b, atol=1e-12) for a, b in zip(shape, there, strict=True))
    plain, gradient, hessian = normal_equations(terms, there, True)
    assert cost == pytest.approx(plain, rel=1e-12)
    axes, eps, _, _, taper = there
    added = add_prior(belief, there, gradient, hessian)
    gaps = np.concatenate([axes, eps, taper])
    over = np.maximum(gaps - belief.ceiling, 0.0)
    expected = 0.5 * np.sum(
        belief.weight * (gaps - belief.mean) ** 2 + belief.ceiling_weight * over**2
    )
    assert added == pytest.approx(expected, rel=1e-9)
    assert total == pytest.approx(plain + expected, rel=1e-9)


@given(seed=seeds, far=st.sampled_from([0.0, 0.05, 0.3]))
def test_the_slope_matches_finite_differences_also_far_from_the_start(seed, far):
    rng = np.random.default_rng(seed)
    terms, start = scene(rng)
    unwhiten, y, belief = (
        0.3 * rng.normal(size=(N_PARAMETERS, 7)),
        far * rng.normal(size=7),
        prior(rng),
    )
    # Exponents stay where the solid has no ridge, points within the taper's reach.
    unwhiten[[2, 3, 4]] *= 0.1
    h = 1e-6
    numeric = [
        (
            at(y + h * d, unwhiten, terms, start, belief)[0]
            - at(y - h * d, unwhiten, terms, start, belief)[0]
        )
        / (2 * h)
        for d in np.eye(7)
    ]
    assert np.allclose(at(y, unwhiten, terms, start, belief)[2], numeric, atol=2e-6)


@given(seed=seeds)
def test_the_slope_of_a_number_beyond_its_bound_is_zero_and_the_number_stays(seed):
    rng = np.random.default_rng(seed)
    terms, start = scene(rng)
    axes, eps, _, _, taper = start
    tight = np.array(
        [[axes.min() - 1, axes.max() + 1], [0.02, eps.max() + 0.01], [-0.9, taper.max() + 0.01]]
    )
    y = np.zeros(N_PARAMETERS)
    held = [3 + int(np.argmax(eps)), 11 + int(np.argmax(taper))]
    y[held] = 0.1
    belief, whole = prior(rng), np.eye(N_PARAMETERS)
    _, _, slope, (_, new_eps, _, _, new_taper) = at(y, whole, terms, start, belief, tight)
    assert np.all(slope[held] == 0.0)
    assert new_eps.max() == tight[1, 1]
    assert new_taper.max() == tight[2, 1]
    h = 1e-6
    for k in range(N_PARAMETERS):
        d = h * np.eye(N_PARAMETERS)[k]
        up, down = (at(y + s * d, whole, terms, start, belief, tight)[0] for s in (1, -1))
        assert slope[k] == pytest.approx((up - down) / (2 * h), abs=2e-6)


@given(seed=seeds, size=st.sampled_from([1e-9, 1e-5, 0.1, 1.0, 3.0]))
def test_the_right_jacobian_tells_how_a_rotation_vector_turns_the_body(seed, size):
    rng = np.random.default_rng(seed)
    vector = rng.normal(size=3)
    vector *= size / np.linalg.norm(vector)
    here, h = Rotation.from_rotvec(vector), 1e-6
    columns = [
        (
            (here.inv() * Rotation.from_rotvec(vector + h * d)).as_rotvec()
            - (here.inv() * Rotation.from_rotvec(vector - h * d)).as_rotvec()
        )
        / (2 * h)
        for d in np.eye(3)
    ]
    assert np.allclose(right_jacobian(vector), np.transpose(columns), atol=1e-8)

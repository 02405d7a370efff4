"""Tests of the optimisers: they return their best point, and a custom one can be added."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, fit_superquadric
from eyehand.perception.superquadric import Kind, sample_surface
from eyehand.perception.superquadric.cost_kernels import normal_equations
from eyehand.perception.superquadric.kinds import basis
from eyehand.perception.superquadric.levenberg_marquardt import add_prior, apply_step
from eyehand.perception.superquadric.outliers import remove_outliers
from eyehand.perception.superquadric.parameters import N_STRAIGHT, ShapeParameters
from eyehand.perception.superquadric.problem import (
    FitProblem,
    Observation,
    build_problem,
    parameter_bounds,
)
from eyehand.perception.superquadric.refine import OPTIMISERS, Refinement

VIEW = np.array([0.3, -0.2, 0.7])
OPTIONS = FitOptions()
KINDS = ("sphere", "cylinder", "box", "superquadric", "tapered")


def make_problem(seed):
    """Return the fit problem of a noisy view of a random solid, and a perturbed start."""
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    e1, e2 = rng.choice([0.1, 0.5, 1.0, 1.5], 2)
    solid = Superquadric(rng.uniform(0.02, 0.07, 3), (float(e1), float(e2)), pose)
    points = sample_surface(solid, 1600, rng)
    points = points[np.einsum("ij,ij->i", VIEW - points, solid.normals(points)) > 0][:400]
    points += 0.001 * rng.normal(size=points.shape)
    problem = build_problem(Observation(remove_outliers(points, VIEW), VIEW), OPTIONS)
    guess = ShapeParameters(
        np.log(solid.semi_axes / problem.unit) + 0.1 * rng.normal(size=3),
        np.clip(np.array(solid.exponents) + 0.1 * rng.normal(size=2), 0.1, 1.9),
        solid.rotation @ Rotation.from_rotvec(0.1 * rng.normal(size=3)).as_matrix(),
        -problem.centre / problem.unit + 0.05 * rng.normal(size=3),
    )
    return problem, guess


def total_cost(problem: FitProblem, guess: ShapeParameters, kind: Kind) -> float:
    """Return the cost with the prior, which the optimisers minimise."""
    tapered = bool(basis(kind)[N_STRAIGHT:].any())
    cost, gradient, hessian = normal_equations(problem.terms, guess, tapered)
    return float(cost) + add_prior(problem.prior, guess, gradient, hessian)


@pytest.mark.parametrize("name", OPTIMISERS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("evaluations", [1, 7, 200])
def test_optimisers_do_not_raise_cost(name, kind, evaluations):
    problem, guess = make_problem(len(name) + len(kind))
    bounds = parameter_bounds(kind, problem, OPTIONS)
    result = OPTIMISERS[name](problem, guess, kind, bounds, evaluations)
    cost_before, cost_after = (
        total_cost(problem, guess, kind),
        total_cost(problem, result.shape, kind),
    )
    assert cost_after <= cost_before * (1 + 1e-12)
    if evaluations == 200 and kind == "superquadric":
        assert cost_after < 0.9 * cost_before
    # The reported cost is the cost of the returned shape.
    tapered = bool(basis(kind)[N_STRAIGHT:].any())
    cost = normal_equations(problem.terms, result.shape, tapered)[0]
    assert result.cost == pytest.approx(float(cost), rel=1e-9)
    # A line search may add evaluations before it stops.
    assert result.evaluations <= evaluations + 2
    assert np.allclose(result.shape.R.T @ result.shape.R, np.eye(3), atol=1e-9)
    assert bounds[1, 0] <= result.shape.exponents.min()
    assert result.shape.exponents.max() <= bounds[1, 1]


@pytest.mark.parametrize("name", [name for name in OPTIMISERS if name != "lm"])
def test_result_is_best_evaluated_point(name, monkeypatch):
    from eyehand.perception.superquadric import refine

    costs: list[float] = []
    compiled = refine.whitened_cost

    def recorded(*arguments):
        output = compiled(*arguments)
        costs.append(float(output[0]))
        return output

    monkeypatch.setattr(refine, "whitened_cost", recorded)
    problem, guess = make_problem(3)
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    result = OPTIMISERS[name](problem, guess, "superquadric", bounds, 40)
    assert len(costs) == result.evaluations
    assert total_cost(problem, result.shape, "superquadric") == pytest.approx(min(costs), rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_slsqp_and_powell_reach_same_cost(seed):
    problem, guess = make_problem(seed)
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    slsqp = OPTIMISERS["slsqp"](problem, guess, "superquadric", bounds, 500)
    low, high = np.full(N_STRAIGHT, -np.inf), np.full(N_STRAIGHT, np.inf)
    low[3:5], high[3:5] = bounds[1, 0] - slsqp.shape.exponents, bounds[1, 1] - slsqp.shape.exponents

    def value(step):
        return total_cost(
            problem, apply_step(slsqp.shape, np.append(step, [0.0, 0.0]), bounds), "superquadric"
        )

    start = total_cost(problem, slsqp.shape, "superquadric")
    powell = minimize(
        value, np.zeros(N_STRAIGHT), method="Powell", bounds=list(zip(low, high, strict=True))
    )
    assert powell.fun > 0.995 * start


@pytest.mark.parametrize("name", OPTIMISERS)
def test_nan_problem_returns_start(name):
    problem, guess = make_problem(1)
    nan_problem = replace(
        problem, terms=problem.terms._replace(points=np.full_like(problem.points, np.nan))
    )
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    result = OPTIMISERS[name](nan_problem, guess, "superquadric", bounds, 30)
    assert all(np.array_equal(a, b) for a, b in zip(result.shape, guess, strict=True))


def test_custom_optimiser_is_used_in_fit(monkeypatch):
    fitted_kinds = []

    def random_search(
        problem: FitProblem, start: ShapeParameters, kind: Kind, bounds: NDArray, evaluations: int
    ) -> Refinement:
        """Try random steps along the free parameters and keep improvements."""
        fitted_kinds.append(kind)
        rng = np.random.default_rng(0)
        best, lowest = start, total_cost(problem, start, kind)
        columns = basis(kind)
        for _ in range(evaluations):
            step = columns @ (1e-3 * rng.normal(size=columns.shape[1]))
            candidate = apply_step(best, step, bounds)
            if total_cost(problem, candidate, kind) < lowest:
                best, lowest = candidate, total_cost(problem, candidate, kind)
        tapered = bool(columns[N_STRAIGHT:].any())
        cost = normal_equations(problem.terms, best, tapered)[0]
        return Refinement(best, float(cost), evaluations)

    monkeypatch.setitem(OPTIMISERS, "lm", random_search)
    ball = Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity())
    points = sample_surface(ball, 300, np.random.default_rng(0))
    fit = fit_superquadric(points, options=FitOptions(optimiser="lm"))
    assert fit
    assert fit.superquadric is not None
    assert fitted_kinds[0] == fit.superquadric.kind
    assert fit.superquadric.semi_axes == pytest.approx([0.04] * 3, abs=1e-3)

"""Every optimiser ends at the best point that it saw, and anybody's fits the same socket."""

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


def posed(seed):
    """A noisy view of a random solid as a problem, and a guess some way off."""
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


def total(problem: FitProblem, guess: ShapeParameters, kind: Kind) -> float:
    """Cost with the prior: what optimisers lower."""
    tapered = bool(basis(kind)[N_STRAIGHT:].any())
    cost, gradient, hessian = normal_equations(problem.terms, guess, tapered)
    return float(cost) + add_prior(problem.prior, guess, gradient, hessian)


@pytest.mark.parametrize("name", OPTIMISERS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("evaluations", [1, 7, 200])
def test_no_optimiser_ends_above_its_start(name, kind, evaluations):
    problem, guess = posed(len(name) + len(kind))
    bounds = parameter_bounds(kind, problem, OPTIONS)
    end = OPTIMISERS[name](problem, guess, kind, bounds, evaluations)
    before, after = total(problem, guess, kind), total(problem, end.shape, kind)
    assert after <= before * (1 + 1e-12)
    if evaluations == 200 and kind == "superquadric":
        assert after < 0.9 * before
    # What it says of its end point is true of it.
    tapered = bool(basis(kind)[N_STRAIGHT:].any())
    cost = normal_equations(problem.terms, end.shape, tapered)[0]
    assert end.cost == pytest.approx(float(cost), rel=1e-9)
    # A line search may look once more before it ends.
    assert end.evaluations <= evaluations + 2
    assert np.allclose(end.shape.R.T @ end.shape.R, np.eye(3), atol=1e-9)
    assert bounds[1, 0] <= end.shape.exponents.min()
    assert end.shape.exponents.max() <= bounds[1, 1]


@pytest.mark.parametrize("name", [name for name in OPTIMISERS if name != "lm"])
def test_the_end_is_the_best_of_all_points_looked_at(name, monkeypatch):
    from eyehand.perception.superquadric import refine

    seen: list[float] = []
    compiled = refine.whitened_cost

    def watched(*arguments):
        answer = compiled(*arguments)
        seen.append(float(answer[0]))
        return answer

    monkeypatch.setattr(refine, "whitened_cost", watched)
    problem, guess = posed(3)
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    end = OPTIMISERS[name](problem, guess, "superquadric", bounds, 40)
    assert len(seen) == end.evaluations
    assert total(problem, end.shape, "superquadric") == pytest.approx(min(seen), rel=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_slsqp_and_a_plain_scipy_descent_end_at_the_same_cost(seed):
    problem, guess = posed(seed)
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    mine = OPTIMISERS["slsqp"](problem, guess, "superquadric", bounds, 500)
    low, high = np.full(N_STRAIGHT, -np.inf), np.full(N_STRAIGHT, np.inf)
    low[3:5], high[3:5] = bounds[1, 0] - mine.shape.exponents, bounds[1, 1] - mine.shape.exponents

    def value(step):
        return total(
            problem, apply_step(mine.shape, np.append(step, [0.0, 0.0]), bounds), "superquadric"
        )

    start = total(problem, mine.shape, "superquadric")
    plain = minimize(
        value, np.zeros(N_STRAIGHT), method="Powell", bounds=list(zip(low, high, strict=True))
    )
    assert plain.fun > 0.995 * start


@pytest.mark.parametrize("name", OPTIMISERS)
def test_a_problem_of_no_numbers_gives_the_start_back(name):
    problem, guess = posed(1)
    nothing = replace(
        problem, terms=problem.terms._replace(points=np.full_like(problem.points, np.nan))
    )
    bounds = parameter_bounds("superquadric", problem, OPTIONS)
    end = OPTIMISERS[name](nothing, guess, "superquadric", bounds, 30)
    assert all(np.array_equal(a, b) for a, b in zip(end.shape, guess, strict=True))


def test_an_optimiser_of_ones_own_takes_part_in_fits(monkeypatch):
    asked = []

    def by_guessing(
        problem: FitProblem, start: ShapeParameters, kind: Kind, bounds: NDArray, evaluations: int
    ) -> Refinement:
        """Try random steps along the kind's free numbers; keep what is better."""
        asked.append(kind)
        rng = np.random.default_rng(0)
        best, lowest = start, total(problem, start, kind)
        columns = basis(kind)
        for _ in range(evaluations):
            step = columns @ (1e-3 * rng.normal(size=columns.shape[1]))
            other = apply_step(best, step, bounds)
            if total(problem, other, kind) < lowest:
                best, lowest = other, total(problem, other, kind)
        tapered = bool(columns[N_STRAIGHT:].any())
        cost = normal_equations(problem.terms, best, tapered)[0]
        return Refinement(best, float(cost), evaluations)

    monkeypatch.setitem(OPTIMISERS, "lm", by_guessing)
    ball = Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity())
    points = sample_surface(ball, 300, np.random.default_rng(0))
    fit = fit_superquadric(points, options=FitOptions(optimiser="lm"))
    assert fit
    assert fit.superquadric is not None
    assert asked[0] == fit.superquadric.kind
    assert fit.superquadric.semi_axes == pytest.approx([0.04] * 3, abs=1e-3)

"""Tests of model selection: the simplest sufficient kind is selected, hopeless kinds skipped."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric
from eyehand.perception.superquadric import PARAMETER_COUNT, Kind, model_selection, sample_surface
from eyehand.perception.superquadric.model_selection import CandidateModel, criterion, select_model
from eyehand.perception.superquadric.outliers import remove_outliers
from eyehand.perception.superquadric.problem import FitProblem, Observation, build_problem

OPTIONS = FitOptions()
SOLIDS: dict[Kind, tuple[list[float], tuple[float, float], tuple[float, float]]] = {
    "sphere": ([0.04, 0.04, 0.04], (1.0, 1.0), (0.0, 0.0)),
    "cylinder": ([0.035, 0.035, 0.06], (0.1, 1.0), (0.0, 0.0)),
    "ellipsoid": ([0.07, 0.05, 0.035], (1.0, 1.0), (0.0, 0.0)),
    "box": ([0.03, 0.05, 0.08], (0.1, 0.1), (0.0, 0.0)),
    "superquadric": ([0.06, 0.045, 0.025], (0.5, 1.6), (0.0, 0.0)),
    "tapered": ([0.04, 0.04, 0.05], (0.2, 1.0), (0.35, 0.35)),
}


def make_problem(kind: Kind, noise=0.001, options=OPTIONS, seed=1) -> FitProblem:
    """Return the fit problem of a solid's whole noisy surface."""
    rng = np.random.default_rng(seed)
    axes, exponents, taper = SOLIDS[kind]
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    solid = Superquadric(np.array(axes), exponents, pose, kind, taper)
    points = sample_surface(solid, 600, rng) + noise * rng.normal(size=(600, 3))
    return build_problem(Observation(remove_outliers(points, None)), options)


def model_kinds(models: list[CandidateModel]) -> list[Kind]:
    return [model.kind for model in models]


@pytest.mark.parametrize("kind", SOLIDS)
def test_simplest_sufficient_kind_is_selected(kind):
    models, _ = select_model(make_problem(kind), False, OPTIONS)
    assert models[0].kind == kind
    criteria = [model.criterion for model in models]
    assert criteria == sorted(criteria)
    # A richer kind may fit the points better, but by less than the penalty of its parameters.
    for model in models[1:]:
        if PARAMETER_COUNT[model.kind] > PARAMETER_COUNT[kind]:
            assert model.cost > 0.9 * models[0].cost


@pytest.mark.parametrize("kind", SOLIDS)
def test_kind_order_does_not_change_result(kind):
    reversed_options = replace(OPTIONS, kinds=OPTIONS.kinds[::-1])
    models, models_of_reversed = (
        select_model(make_problem(kind), False, OPTIONS)[0],
        select_model(make_problem(kind), False, reversed_options)[0],
    )
    assert model_kinds(models) == model_kinds(models_of_reversed)
    assert [model.criterion for model in models] == [
        model.criterion for model in models_of_reversed
    ]


def test_kinds_that_cannot_win_are_not_fitted():
    ball, _ = select_model(make_problem("sphere", noise=1e-4), False, OPTIONS)
    assert model_kinds(ball) == ["sphere"]
    cylinder, _ = select_model(make_problem("cylinder", noise=1e-4), False, OPTIONS)
    assert set(model_kinds(cylinder)) == {"cylinder", "sphere"}
    # At the expected noise a surface can look tapered by chance.
    for kind in ("sphere", "box", "superquadric"):
        assert "tapered" not in model_kinds(select_model(make_problem(kind), False, OPTIONS)[0])


def test_unrequested_kinds_are_not_fitted():
    models, _ = select_model(
        make_problem("box"), False, replace(OPTIONS, kinds=("cylinder", "ellipsoid"))
    )
    assert set(model_kinds(models)) == {"cylinder", "ellipsoid"}


@pytest.mark.parametrize("kind", SOLIDS)
def test_pruned_kinds_lose_on_all_points(kind, monkeypatch):
    calls = []
    compiled = model_selection.levenberg_marquardt

    def counted(problem, *rest, **more):
        calls.append(len(problem.points))
        return compiled(problem, *rest, **more)

    monkeypatch.setattr(model_selection, "levenberg_marquardt", counted)
    problem, prune_margin = make_problem(kind), model_selection.PRUNE_MARGIN
    pruned, _ = select_model(problem, False, OPTIONS)
    count_pruned = calls.count(len(problem.points))
    calls.clear()
    monkeypatch.setattr(model_selection, "PRUNE_MARGIN", 1e6)
    unpruned, _ = select_model(problem, False, OPTIONS)
    assert count_pruned < calls.count(len(problem.points))
    assert unpruned[0].kind == pruned[0].kind
    assert unpruned[0].criterion == pytest.approx(pruned[0].criterion, abs=0.5)
    # A pruned model keeps its gap on few points, which is more than half of the prune margin.
    close = [model for model in unpruned[1:] if model.criterion < unpruned[0].criterion + 5.0]
    assert set(model_kinds(close)) <= set(model_kinds(pruned))
    trailing = model_kinds(pruned)[count_pruned:]
    for model in unpruned:
        if model.kind in trailing:
            assert model.criterion > unpruned[0].criterion + 5.0
    for model in pruned:
        if model.kind in trailing:
            assert model.criterion > pruned[0].criterion + 0.5 * prune_margin


def test_criterion_is_bic_with_noise_floor():
    problem = replace(make_problem("box"), samples=80.0)
    floor = 0.5 * OPTIONS.noise / problem.unit
    value = criterion(0.01, "box", problem, OPTIONS)
    assert value == pytest.approx(80.0 * np.log(0.02 + floor**2) + 9 * np.log(80.0))
    step = criterion(0.01, "superquadric", problem, OPTIONS) - value
    assert step == pytest.approx(2 * np.log(80.0))
    # Residuals at a tenth of the noise give no more evidence than residuals at a fifth.
    tiny = [criterion(0.5 * (floor / share) ** 2, "box", problem, OPTIONS) for share in (5, 10)]
    assert tiny[0] - tiny[1] < np.log(80.0)


def test_effective_samples_follow_residuals_of_best_solid():
    _, white = select_model(make_problem("superquadric"), False, OPTIONS)
    _, wavy = select_model(
        make_problem("tapered"), False, replace(OPTIONS, kinds=("sphere", "cylinder"))
    )
    assert white.samples > 1.5 * wavy.samples


def test_criterion_equals_cost_on_returned_problem():
    problem = make_problem("cylinder")
    models, final_problem = select_model(problem, False, OPTIONS)
    best = models[0]
    assert best.criterion == pytest.approx(criterion(best.cost, best.kind, final_problem, OPTIONS))

"""Model selection: the simplest sufficient solid wins, and kinds that cannot win cost nothing."""

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


def posed(kind: Kind, noise=0.001, options=OPTIONS, seed=1) -> FitProblem:
    """A solid's whole surface as a problem."""
    rng = np.random.default_rng(seed)
    axes, exponents, taper = SOLIDS[kind]
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    solid = Superquadric(np.array(axes), exponents, pose, kind, taper)
    points = sample_surface(solid, 600, rng) + noise * rng.normal(size=(600, 3))
    return build_problem(Observation(remove_outliers(points, None)), options)


def kinds(models: list[CandidateModel]) -> list[Kind]:
    return [model.kind for model in models]


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_simplest_sufficient_solid_wins(kind):
    models, _ = select_model(posed(kind), False, OPTIONS)
    assert models[0].kind == kind
    criteria = [model.criterion for model in models]
    assert criteria == sorted(criteria)
    # A richer solid may lie nearer to the points, by less than its numbers cost.
    for model in models[1:]:
        if PARAMETER_COUNT[model.kind] > PARAMETER_COUNT[kind]:
            assert model.cost > 0.9 * models[0].cost


@pytest.mark.parametrize("kind", SOLIDS)
def test_order_of_kinds_does_not_matter(kind):
    turned = replace(OPTIONS, kinds=OPTIONS.kinds[::-1])
    here, there = (
        select_model(posed(kind), False, OPTIONS)[0],
        select_model(posed(kind), False, turned)[0],
    )
    assert kinds(here) == kinds(there)
    assert [one.criterion for one in here] == [one.criterion for one in there]


def test_kinds_that_cannot_pay_for_their_numbers_are_not_tried():
    ball, _ = select_model(posed("sphere", noise=1e-4), False, OPTIONS)
    assert kinds(ball) == ["sphere"]
    can, _ = select_model(posed("cylinder", noise=1e-4), False, OPTIONS)
    assert set(kinds(can)) == {"cylinder", "sphere"}
    # At the noise expected of it a surface may look tapered by chance.
    for kind in ("sphere", "box", "superquadric"):
        assert "tapered" not in kinds(select_model(posed(kind), False, OPTIONS)[0])


def test_kinds_not_asked_for_are_not_tried():
    models, _ = select_model(posed("box"), False, replace(OPTIONS, kinds=("cylinder", "ellipsoid")))
    assert set(kinds(models)) == {"cylinder", "ellipsoid"}


@pytest.mark.parametrize("kind", SOLIDS)
def test_kinds_that_trail_on_few_points_trail_in_the_end(kind, monkeypatch):
    finished = []
    compiled = model_selection.levenberg_marquardt

    def watched(problem, *rest, **more):
        finished.append(len(problem.points))
        return compiled(problem, *rest, **more)

    monkeypatch.setattr(model_selection, "levenberg_marquardt", watched)
    problem, prune_margin = posed(kind), model_selection.PRUNE_MARGIN
    pruned, _ = select_model(problem, False, OPTIONS)
    cheap = finished.count(len(problem.points))
    finished.clear()
    monkeypatch.setattr(model_selection, "PRUNE_MARGIN", 1e6)
    whole, _ = select_model(problem, False, OPTIONS)
    assert cheap < finished.count(len(problem.points))
    assert whole[0].kind == pruned[0].kind
    assert whole[0].criterion == pytest.approx(pruned[0].criterion, abs=0.5)
    # Not finished, a model is as far behind as it was on few points: more than half of prune.
    close = [model for model in whole[1:] if model.criterion < whole[0].criterion + 5.0]
    assert set(kinds(close)) <= set(kinds(pruned))
    trailing = kinds(pruned)[cheap:]
    for model in whole:
        if model.kind in trailing:
            assert model.criterion > whole[0].criterion + 5.0
    for model in pruned:
        if model.kind in trailing:
            assert model.criterion > pruned[0].criterion + 0.5 * prune_margin


def test_the_criterion_is_bic_with_a_floor_of_half_the_noise():
    problem = replace(posed("box"), samples=80.0)
    floor = 0.5 * OPTIONS.noise / problem.unit
    value = criterion(0.01, "box", problem, OPTIONS)
    assert value == pytest.approx(80.0 * np.log(0.02 + floor**2) + 9 * np.log(80.0))
    step = criterion(0.01, "superquadric", problem, OPTIONS) - value
    assert step == pytest.approx(2 * np.log(80.0))
    # Ten times better than the noise is no more evidence than five times.
    tiny = [criterion(0.5 * (floor / share) ** 2, "box", problem, OPTIONS) for share in (5, 10)]
    assert tiny[0] - tiny[1] < np.log(80.0)


def test_readings_follow_the_residuals_of_the_closest_solid():
    _, white = select_model(posed("superquadric"), False, OPTIONS)
    _, wavy = select_model(posed("tapered"), False, replace(OPTIONS, kinds=("sphere", "cylinder")))
    assert white.samples > 1.5 * wavy.samples


def test_cloud_and_guess_of_a_rung_agree_on_its_cost():
    problem = posed("cylinder")
    models, judged = select_model(problem, False, OPTIONS)
    best = models[0]
    assert best.criterion == pytest.approx(criterion(best.cost, best.kind, judged, OPTIONS))

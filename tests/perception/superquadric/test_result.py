"""Tests of fit results: runner-up, margin and alternatives."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import CandidateSolid, sample_surface
from eyehand.perception.superquadric.finish import DIRECTIONS, SHAPE_TOLERANCE
from eyehand.perception.superquadric.result import AMBIGUOUS_MARGIN
from eyehand.perception.superquadric.robust import robust_spread

VIEW = np.array([0.2, 0.1, -0.7])
BALL = Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity(), "sphere")


def candidate(criterion: float) -> CandidateSolid:
    return CandidateSolid(BALL, 0.001, criterion)


def result(*criteria: float) -> SuperquadricFit:
    candidates = tuple(candidate(criterion) for criterion in criteria)
    return SuperquadricFit(BALL, True, "", np.zeros(3), candidates, 0.0)


def fit_noisy_view(seed) -> SuperquadricFit:
    """Fit few points of one view, with so much noise that the shape is ambiguous."""
    rng = np.random.default_rng(seed)
    axes, (e1, e2) = rng.uniform(0.02, 0.08, 3), rng.choice([0.1, 0.3, 0.5, 1.0, 1.5], 2)
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    solid = Superquadric(axes, (float(e1), float(e2)), pose)
    points = sample_surface(solid, 400, rng)
    points = points[np.einsum("ij,ij->i", VIEW - points, solid.normals(points)) > 0][:90]
    return fit_superquadric(points + 0.003 * rng.normal(size=points.shape), view_origin=VIEW)


def difference(first: Superquadric, second: Superquadric) -> float:
    return float(np.abs(first.support(DIRECTIONS) - second.support(DIRECTIONS)).max())


def test_margin_and_runner_up_follow_candidates():
    fit = result(-10.0, -7.5, 3.0)
    assert fit.margin == pytest.approx(2.5)
    assert fit.runner_up is fit.candidates[1]
    single = result(-10.0)
    assert single.runner_up is None
    assert single.margin == np.inf
    assert not single.ambiguous


def test_robust_spread_equals_sigma_and_ignores_outliers():
    residuals = 0.002 * np.random.default_rng(0).normal(size=20000)
    assert robust_spread(residuals) == pytest.approx(0.002, rel=0.03)
    residuals[:1000] = 1.0
    assert robust_spread(residuals) == pytest.approx(0.002, rel=0.1)
    assert robust_spread(np.zeros(0)) == np.inf


def test_usable_result_is_true():
    assert result(0.0)
    rejected_fit = SuperquadricFit.rejected("too few", 0.25)
    assert not rejected_fit
    assert (rejected_fit.reason, rejected_fit.seconds) == ("too few", 0.25)


def test_alternatives_differ_in_shape_within_margin():
    ambiguous = 0
    for seed in range(60):
        fit = fit_noisy_view(seed)
        if fit.superquadric is None:
            continue
        selected = fit.candidates[0]
        assert selected.superquadric is fit.superquadric
        assert fit.ambiguous == (len(fit.alternatives) > 0)
        tolerance = SHAPE_TOLERANCE * FitOptions().noise
        for other in fit.alternatives:
            assert other.criterion < selected.criterion + AMBIGUOUS_MARGIN
            assert difference(selected.superquadric, other.superquadric) > tolerance
        for model in fit.candidates[1:]:
            within_margin = model.criterion < selected.criterion + AMBIGUOUS_MARGIN
            other = difference(selected.superquadric, model.superquadric) > tolerance
            assert any(model is one for one in fit.alternatives) == (within_margin and other)
        ambiguous += fit.ambiguous
    assert 3 <= ambiguous < 45


@pytest.mark.parametrize("seed", range(4))
def test_whole_box_is_unambiguous(seed):
    rng = np.random.default_rng(seed)
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    brick = Superquadric(np.array([0.05, 0.04, 0.03]), (0.1, 0.1), pose, "box")
    fit = fit_superquadric(sample_surface(brick, 800, rng) + 0.001 * rng.normal(size=(800, 3)))
    assert fit.superquadric is not None
    assert fit.superquadric.kind == "box"
    assert not fit.ambiguous
    assert fit.margin > AMBIGUOUS_MARGIN
    assert fit.runner_up is not None
    assert fit.runner_up.kind == "superquadric"
    assert difference(brick, fit.superquadric) < 0.002


def test_solids_and_results_support_membership_tests():
    copy = Superquadric(BALL.semi_axes, BALL.exponents, BALL.pose, BALL.kind)
    fits = [result(1.0), result(2.0)]
    assert BALL in (copy, BALL)
    assert copy not in (BALL,)
    assert len({BALL, copy}) == 2
    assert fits.index(fits[1]) == 1
    assert candidate(1.0) == candidate(1.0)


def test_candidates_have_unique_kinds_and_selected_first():
    for seed in range(10):
        fit = fit_noisy_view(seed)
        kinds = [model.kind for model in fit.candidates]
        assert len(kinds) == len(set(kinds))
        if fit.superquadric is not None:
            assert fit.superquadric is fit.candidates[0].superquadric
            assert fit.parts == (fit.superquadric,)

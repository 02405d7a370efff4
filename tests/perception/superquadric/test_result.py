"""What a result says of its runner-up, its margin, and of other shapes within the noise."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import FitOptions, Superquadric, SuperquadricFit, fit_superquadric
from eyehand.perception.superquadric import CandidateSolid, sample_surface
from eyehand.perception.superquadric.fit import DIRECTIONS, SHAPE_TOLERANCE
from eyehand.perception.superquadric.result import AMBIGUOUS_MARGIN
from eyehand.perception.superquadric.robust import robust_spread

VIEW = np.array([0.2, 0.1, -0.7])
BALL = Superquadric(np.full(3, 0.04), (1.0, 1.0), RigidTransform.identity(), "sphere")


def candidate(criterion: float) -> CandidateSolid:
    return CandidateSolid(BALL, 0.001, criterion)


def result(*criteria: float) -> SuperquadricFit:
    candidates = tuple(candidate(criterion) for criterion in criteria)
    return SuperquadricFit(BALL, True, "", np.zeros(3), candidates, 0.0)


def doubtful(seed) -> SuperquadricFit:
    """Fit of few points of one view, with noise that hides what the solid is."""
    rng = np.random.default_rng(seed)
    axes, (e1, e2) = rng.uniform(0.02, 0.08, 3), rng.choice([0.1, 0.3, 0.5, 1.0, 1.5], 2)
    pose = RigidTransform.from_rotation(Rotation.random(rng=rng))
    solid = Superquadric(axes, (float(e1), float(e2)), pose)
    points = sample_surface(solid, 400, rng)
    points = points[np.einsum("ij,ij->i", VIEW - points, solid.normals(points)) > 0][:90]
    return fit_superquadric(points + 0.003 * rng.normal(size=points.shape), view_origin=VIEW)


def difference(first: Superquadric, second: Superquadric) -> float:
    return float(np.abs(first.support(DIRECTIONS) - second.support(DIRECTIONS)).max())


def test_margin_and_runner_up_are_read_off_the_ladder():
    fit = result(-10.0, -7.5, 3.0)
    assert fit.margin == pytest.approx(2.5)
    assert fit.runner_up is fit.candidates[1]
    alone = result(-10.0)
    assert alone.runner_up is None
    assert alone.margin == np.inf
    assert not alone.ambiguous


def test_the_spread_is_that_of_a_normal_distribution_and_ignores_a_few_outliers():
    residuals = 0.002 * np.random.default_rng(0).normal(size=20000)
    assert robust_spread(residuals) == pytest.approx(0.002, rel=0.03)
    residuals[:1000] = 1.0
    assert robust_spread(residuals) == pytest.approx(0.002, rel=0.1)
    assert robust_spread(np.zeros(0)) == np.inf


def test_a_result_is_true_when_it_can_be_used():
    assert result(0.0)
    refused = SuperquadricFit.rejected("too few", 0.25)
    assert not refused
    assert (refused.reason, refused.seconds) == ("too few", 0.25)


def test_alternatives_are_other_shapes_within_the_noise_and_only_those():
    ambiguous = 0
    for seed in range(60):
        fit = doubtful(seed)
        if fit.superquadric is None:
            continue
        chosen = fit.candidates[0]
        assert chosen.superquadric is fit.superquadric
        assert fit.ambiguous == (len(fit.alternatives) > 0)
        apart = SHAPE_TOLERANCE * FitOptions().noise
        for other in fit.alternatives:
            assert other.criterion < chosen.criterion + AMBIGUOUS_MARGIN
            assert difference(chosen.superquadric, other.superquadric) > apart
        for model in fit.candidates[1:]:
            near = model.criterion < chosen.criterion + AMBIGUOUS_MARGIN
            other = difference(chosen.superquadric, model.superquadric) > apart
            assert any(model is one for one in fit.alternatives) == (near and other)
        ambiguous += fit.ambiguous
    assert 3 <= ambiguous < 45


@pytest.mark.parametrize("seed", range(4))
def test_a_brick_seen_all_round_is_a_brick_and_nothing_else(seed):
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


def test_solids_and_results_can_be_looked_up_in_collections():
    twin = Superquadric(BALL.semi_axes, BALL.exponents, BALL.pose, BALL.kind)
    fits = [result(1.0), result(2.0)]
    assert BALL in (twin, BALL)
    assert twin not in (BALL,)
    assert len({BALL, twin}) == 2
    assert fits.index(fits[1]) == 1
    assert candidate(1.0) == candidate(1.0)


def test_the_ladder_holds_each_kind_once_and_the_chosen_solid_first():
    for seed in range(10):
        fit = doubtful(seed)
        kinds = [model.kind for model in fit.candidates]
        assert len(kinds) == len(set(kinds))
        if fit.superquadric is not None:
            assert fit.superquadric is fit.candidates[0].superquadric
            assert fit.parts == (fit.superquadric,)

"""Clouds of the sweeps have the stated difficulty."""

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform

from eyehand.apps.bench import Sweep
from eyehand.apps.fitting.bench.compound_solids import CompoundSolid
from eyehand.apps.fitting.bench.fit_answer import FitAnswer
from eyehand.apps.fitting.bench.rendered_sweeps import rendered_sweeps
from eyehand.apps.fitting.bench.score import union_distances
from eyehand.apps.fitting.bench.stress import fit_sweeps
from eyehand.apps.fitting.bench.stress_views import CloudView, one_view, usual_solid
from eyehand.apps.fitting.bench.true_solid import convex_parts
from eyehand.perception import Superquadric

SWEEPS = {sweep.name: sweep for sweep in fit_sweeps()}
RENDERED = {sweep.name for sweep in rendered_sweeps()}


def view_of(name: str, value: float, seed: int = 0) -> CloudView:
    """Return the last view that a trial gives to the method."""
    return views_of(SWEEPS[name], value, seed)[-1]


def views_of(sweep: Sweep, value: float, seed: int = 0) -> list[CloudView]:
    views: list[CloudView] = []

    def refuse(view: CloudView) -> FitAnswer:
        views.append(view)
        return FitAnswer((), "none of these")

    sweep.attempt(value, seed, refuse)
    return views


def truth(view: CloudView) -> Superquadric:
    """Return the true superquadric of a view."""
    assert isinstance(view.truth, Superquadric)
    return view.truth


def test_sweeps_have_unique_names_and_state_what_is_right():
    assert len(SWEEPS) == len(fit_sweeps()) >= 18
    assert all(sweep.axis and sweep.right for sweep in SWEEPS.values())


@pytest.mark.parametrize("sweep", SWEEPS.values(), ids=lambda sweep: sweep.name)
def test_trial_depends_on_value_and_seed_only(sweep: Sweep):
    for value in (sweep.values[0], sweep.values[-1]):
        first, again, other = (views_of(sweep, value, seed)[0] for seed in (3, 3, 4))
        assert np.array_equal(first.points, again.points)
        assert first.points.shape != other.points.shape or np.any(first.points != other.points)
        assert np.all(np.isfinite(first.points))


@pytest.mark.parametrize(
    "name", sorted(SWEEPS.keys() - {"points", "far", "sheet", "wire"} - RENDERED)
)
def test_true_solid_passes_every_sweep(name):
    for value in SWEEPS[name].values:
        trial = SWEEPS[name].attempt(value, 1, lambda view: FitAnswer((truth(view),), ""))
        assert (trial.passed, trial.score) == (True, 1.0)
        assert len(view_of(name, value).points) == 1000


@pytest.mark.parametrize("name", sorted(RENDERED))
def test_true_parts_pass_every_rendered_sweep(name):
    def answer(view: CloudView) -> FitAnswer:
        solid = view.truth
        if isinstance(solid, CompoundSolid):
            return FitAnswer(solid.parts)
        return FitAnswer((truth(view),))

    for value in SWEEPS[name].values:
        trial = SWEEPS[name].attempt(value, 1, answer)
        assert (trial.passed, trial.score) == (True, 1.0)


def test_rendered_points_lie_on_the_solid_and_beside_free_space():
    for name in ("thin", "bent", "frontal"):
        view = view_of(name, SWEEPS[name].values[0])
        assert view.truth is not None
        distance = np.abs(union_distances(view.points, convex_parts(view.truth)))
        assert np.quantile(distance, 0.9) < 0.003
        assert view.free_space is not None
        assert not view.free_space.on_object.all()
        assert view.margin > 0
    assert len(view_of("hidden", 75).points) < len(view_of("hidden", 0).points)


def test_a_wrong_solid_with_a_doubt_is_no_silent_failure():
    def answer(doubted: bool):
        small = Superquadric(np.full(3, 0.01), (1.0, 1.0), RigidTransform.identity(), "sphere")
        return lambda view: FitAnswer((small,), "", doubted)

    silent, said = (SWEEPS["bent"].attempt(90, 0, answer(doubted)) for doubted in (False, True))
    assert (silent.passed, said.passed) == (False, True)
    assert silent.score is not None
    assert said.score is None


def test_points_sweep_has_the_given_number_of_points():
    for count in SWEEPS["points"].values:
        assert len(view_of("points", count).points) == count
    trial = SWEEPS["points"].attempt(49 - 9, 0, lambda view: FitAnswer((truth(view),), ""))
    assert not trial.passed
    assert trial.note.startswith("not refused")


def test_noise_sweep_has_the_given_noise():
    exact = view_of("noise", 0)
    assert np.abs(truth(exact).distance(exact.points)).max() < 1e-9
    for sigma in (1, 5):
        view = view_of("noise", sigma)
        assert np.std(view.points - exact.points) == pytest.approx(1e-3 * sigma, rel=0.05)


def test_outlier_sweep_has_the_given_share():
    for share in (0, 20, 60):
        view = view_of("outliers", share)
        far = np.abs(truth(view).distance(view.points)) > 0.006
        assert share / 100 - 0.12 < far.mean() < share / 100 + 0.01


def test_smaller_shares_cover_less_of_the_surface():
    reach = []
    for share in (100, 50, 10):
        view = view_of("seen", share)
        assert view.view_origin is None
        along = (view.points - truth(view).centre) @ (usual_solid(0)[1] - truth(view).centre)
        reach.append(np.ptp(along))
    assert reach[0] > 1.5 * reach[1] > 2 * reach[2]


@pytest.mark.parametrize("seed", [0, 1])
def test_occluder_hides_exactly_the_removed_points(seed):
    whole = one_view(*usual_solid(seed), np.random.default_rng(0), count=5000)
    for share in (80, 50, 10):
        view = view_of("occluded", share, seed)
        free_space = view.free_space
        assert free_space is not None
        seen, rest = (points - free_space.origin for points in (view.points, whole.points))
        seen, rest = (one / np.linalg.norm(one, axis=1, keepdims=True) for one in (seen, rest))
        occluded = np.isfinite(free_space.depth) & ~free_space.on_object
        nearest = free_space.rays[occluded] @ rest.T
        assert occluded.any()
        covered = np.arccos(nearest.max(axis=0).clip(-1, 1)) < 0.75 * free_space.pitch
        assert covered.mean() == pytest.approx(1 - share / 100, abs=0.12)
        near = np.arccos((free_space.rays[occluded] @ seen.T).max(axis=0).clip(-1, 1))
        assert np.mean(near < 0.75 * free_space.pitch) < 0.3


def test_views_are_at_the_given_angle():
    for name, angle in (("face-on", 0), ("face-on", 20), ("end-on", 0), ("side-on", 90)):
        view = view_of(name, angle)
        assert view.view_origin is not None
        towards = truth(view).to_local(view.view_origin)
        assert np.linalg.norm(towards) == pytest.approx(0.7)
        assert np.degrees(np.arccos(towards[2] / 0.7)) == pytest.approx(angle, abs=1e-5)
    slanting = view_of("face-on", 55)
    assert slanting.view_origin is not None
    corner = truth(slanting).to_local(slanting.view_origin)
    assert corner == pytest.approx([0.4] * 3, abs=0.01)
    above = view_of("from-above", 90)
    assert above.support_plane is not None
    assert truth(above).support([0.0, 0.0, -1.0]) == pytest.approx(0.0, abs=1e-12)


def test_solids_have_the_given_exponents_and_aspect_ratios():
    assert truth(view_of("sharp", 0.05)).exponents == (0.05, 0.05)
    assert truth(view_of("pinched", 1.95)).exponents == (1.95, 1.95)
    assert truth(view_of("diamond", 0.05)).exponents == (0.05, 1.95)
    assert truth(view_of("tent", 0.05)).exponents == (1.95, 0.05)
    assert truth(view_of("rod", 20)).semi_axes == pytest.approx([0.005, 0.005, 0.1])
    assert truth(view_of("plate", 20)).semi_axes == pytest.approx([0.1, 0.1, 0.005])


def test_sheets_and_wires_have_stated_extents():
    for name, rank in (("sheet", 2), ("wire", 1)):
        exact, noisy = (view_of(name, value).points for value in (0, 5))
        extents = [np.linalg.svd(p - p.mean(axis=0), compute_uv=False) for p in (exact, noisy)]
        assert np.count_nonzero(extents[0] > 1e-9) == rank
        assert extents[1][rank] / np.sqrt(1000) == pytest.approx(5e-3, rel=0.1)


def test_far_clouds_are_translated_near_clouds():
    near, far = views_of(SWEEPS["far"], 10_000)
    assert np.linalg.norm(far.points.mean(axis=0)) == pytest.approx(1e4, rel=1e-3)
    spread = [np.ptp(view.points, axis=0) for view in (near, far)]
    assert spread[0] == pytest.approx(spread[1], abs=1e-10)

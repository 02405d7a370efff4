"""Trials of the fit stress test: right, refused, failed silently, and invalid answers."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.apps.fitting.bench import stress_trial as stress_fit_trial
from eyehand.apps.fitting.bench.fit_answer import FitAnswer
from eyehand.apps.fitting.bench.stress_trial import (
    FitCallable,
    baseline_method,
    fit_method,
    overshoot,
    surface_distance,
    try_fit,
    try_following,
    try_refusal,
    try_shapeless_points,
)
from eyehand.apps.fitting.bench.stress_views import CloudView, moved, one_view, scaled
from eyehand.perception import Superquadric

PLACE = RigidTransform.from_components([0.1, -0.2, 0.3], Rotation.from_rotvec([0.4, 0.2, -0.7]))
BALL = Superquadric(np.full(3, 0.05), (1.0, 1.0), PLACE, "sphere")
BRICK = Superquadric(np.array([0.03, 0.04, 0.06]), (0.1, 0.1), PLACE, "box")
CAMERA = np.array([0.5, 0.3, 0.9])
VIEW = one_view(BALL, CAMERA, np.random.default_rng(0))


def sized(factor: float) -> Superquadric:
    """Return the ball with another radius."""
    return replace(BALL, semi_axes=factor * BALL.semi_axes)


def always(*solids: Superquadric, reason: str = "") -> FitCallable:
    """Return a method with the same answer to every view."""
    return lambda view: FitAnswer(solids, reason)


def test_true_solid_is_right():
    trial = try_fit(always(BALL), VIEW, 0)
    assert (trial.passed, trial.clean, trial.refused, trial.note) == (True, True, False, "")
    assert trial.score == 1.0
    assert trial.seconds is not None


@pytest.mark.parametrize(("radius", "right"), [(0.95, True), (0.85, False), (0.7, False)])
def test_solid_is_right_from_75_pct_iou(radius, right):
    trial = try_fit(always(sized(radius)), VIEW, 0)
    assert trial.score == pytest.approx(radius**3, abs=0.01)
    assert trial.passed == right
    assert (trial.note == "") == right


def test_iou_counts_the_union_of_parts():
    halves = [
        replace(BALL, pose=PLACE * RigidTransform.from_translation([x, 0, 0])) for x in (0, 9)
    ]
    both = replace(VIEW, truth=halves[0])
    assert (try_fit(always(*halves), both, 0).score or 1) < 0.6


def test_refusal_must_name_the_fault():
    refusing = always(reason="49 points are too few")
    trial = try_fit(refusing, VIEW, 0)
    assert (trial.passed, trial.refused, trial.score) == (False, True, None)
    assert try_shapeless_points(refusing, VIEW).passed
    assert try_refusal(refusing, VIEW, "too few").passed
    unnamed = try_refusal(refusing, VIEW, "line")
    assert (unnamed.passed, unnamed.note) == (False, "refused, but: 49 points are too few")
    accepted = try_refusal(always(BALL), VIEW, "line")
    assert (accepted.passed, accepted.note) == (False, "not refused: sphere of 100 x 100 x 100 mm")


def test_solid_beyond_shapeless_points_is_wrong():
    assert overshoot(BALL, VIEW.points + 1e3 * np.eye(3)[0]) == pytest.approx(1e3, abs=5)
    points = 0.05 * np.random.default_rng(0).uniform(-1, 1, (500, 3)) * [1, 1, 0] + BALL.centre
    view = CloudView(points)
    thin = replace(
        BRICK,
        semi_axes=np.array([0.05, 0.05, 0.005]),
        pose=RigidTransform.from_translation(BALL.centre),
    )
    assert try_shapeless_points(always(thin), view).passed
    trial = try_shapeless_points(always(replace(thin, semi_axes=np.array([0.05, 0.05, 0.2]))), view)
    assert not trial.passed
    assert trial.note.startswith("200 mm beyond the points: box of 100 x 100 x 400 mm")


@pytest.mark.parametrize("first", [BALL, BRICK])
def test_surface_distance_equals_the_translation(first):
    assert surface_distance(first, first) < 1e-9
    for off in (1e-6, 1e-3):
        other = replace(first, pose=RigidTransform.from_translation([0, 0, off]) * first.pose)
        size = first.semi_axes.max()
        assert surface_distance(first, other) == pytest.approx(off / size, rel=0.02)
        far = RigidTransform.from_translation([6e3, -5e3, 4e3])
        here, there = (replace(solid, pose=far * solid.pose) for solid in (first, other))
        assert surface_distance(here, there) == pytest.approx(off / size, rel=0.02)


def test_solid_must_move_with_the_cloud():
    T = RigidTransform.from_components([3.0, 1.0, 2.0], Rotation.from_rotvec([1.0, 0.5, 0.2]))

    def follows(view: CloudView) -> FitAnswer:
        # The camera position tells which of the two views this is.
        assert view.view_origin is not None
        here = np.allclose(view.view_origin, CAMERA)
        return FitAnswer((BRICK if here else replace(BRICK, pose=T * BRICK.pose),), "")

    assert try_following(follows, VIEW, moved(VIEW, T), T, 0).passed
    trial = try_following(always(BRICK), VIEW, moved(VIEW, T), T, 0)
    assert not trial.passed
    assert trial.note.endswith("of its size off")
    larger = replace(scaled(VIEW, 2.0), unit=0.5)
    assert not try_following(always(BRICK), VIEW, larger, RigidTransform.identity(), 0).passed
    refused = try_following(always(reason="no"), VIEW, moved(VIEW, T), T, 0)
    assert (refused.passed, refused.note) == (False, "refused both: no")


def test_options_are_scaled_with_the_unit():
    here = fit_method(VIEW)
    there = fit_method(replace(scaled(VIEW, 1000.0), unit=1e-3))
    assert here.reason == there.reason == ""
    # A ball of 50 m is out of range.
    assert fit_method(scaled(VIEW, 1000.0)).reason
    assert there.parts[0].semi_axes == pytest.approx(1000 * here.parts[0].semi_axes, rel=1e-6)


def test_baseline_is_used_as_a_method():
    calls = []

    def baseline(points, view_origin, support_plane):
        calls.append((points, view_origin, support_plane))
        return BALL if len(calls) == 1 else None

    assert baseline_method(baseline)(VIEW) == FitAnswer((BALL,), "")
    assert baseline_method(baseline)(VIEW).reason == "no solid found"
    assert calls[0][0] is VIEW.points
    assert calls[0][1] is CAMERA
    assert calls[0][2] is None


def test_invalid_answers_are_unclean(monkeypatch):
    def warns(view: CloudView) -> FitAnswer:
        warnings.warn("overflow\nencountered", RuntimeWarning, stacklevel=1)
        return FitAnswer((BALL,), "")

    trial = try_fit(warns, VIEW, 0)
    assert (trial.passed, trial.clean, trial.note) == (False, False, "warned: overflow encountered")
    empty = try_refusal(always(), VIEW, "few")
    assert (empty.clean, empty.note) == (False, "neither a solid nor a reason")
    monkeypatch.setattr(stress_fit_trial, "MAX_SECONDS", -1.0)
    assert try_fit(always(BALL), VIEW, 0).note.startswith("took")

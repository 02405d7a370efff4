"""Odd clouds: the fit refuses them, or its solid has not failed and stays within the points."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from eyehand.apps.fitting.bench.clouds import POINTS
from eyehand.apps.fitting.bench.fit_answer import FAILED
from eyehand.apps.fitting.bench.stress_trial import fit_method, try_fit, try_shapeless_points
from eyehand.apps.fitting.bench.stress_views import CloudView, one_view, usual_solid

FAR = 1e4
"""Distance of far clouds from the origin, m."""
REACH = 0.05
"""Half extent of points that belong to no solid, m."""


def stray(points: np.ndarray, away: float) -> np.ndarray:
    """Add a point at a distance from the others, m."""
    return np.vstack([points, points[:1] + np.array([away, 0.0, 0.0])])


def many(points: np.ndarray) -> np.ndarray:
    copies = points.repeat(100, axis=0)
    return copies + 0.0005 * np.random.default_rng(0).normal(size=copies.shape)


CHANGED_POINTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "50 points": lambda p: p[:50],
    "rounded to 10 mm": lambda p: p.round(2),
    "single precision 10 km away": lambda p: (p + FAR).astype(np.float32).astype(float) - FAR,
    "half of all points at one place": lambda p: np.vstack([p[:500], p[:1].repeat(500, axis=0)]),
    "one point 1 m away": lambda p: stray(p, 1.0),
    "one point 100 km away": lambda p: stray(p, 1e5),
    "100 000 points": many,
}
CAMERAS: dict[str, Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]] = {
    "inside the solid": lambda camera, middle, point: middle,
    "at a point": lambda camera, middle, point: point,
    "1000 km behind": lambda camera, middle, point: 1e6 * camera,
    "on the wrong side": lambda camera, middle, point: 2 * middle - camera,
}
SHAPELESS: dict[str, Callable[[np.random.Generator], np.ndarray]] = {
    "a filled ball": lambda rng: REACH * rng.normal(size=(POINTS, 3)),
    "a filled cube": lambda rng: rng.uniform(-REACH, REACH, (POINTS, 3)),
    "a ring of wire": lambda rng: ring(rng, 0.0),
    "a noisy ring of wire": lambda rng: ring(rng, 0.0005),
    "the corners of a cube": lambda rng: (
        REACH * rng.choice([-1.0, 1.0], (POINTS, 3)) + 0.001 * rng.normal(size=(POINTS, 3))
    ),
    "one noisy point": lambda rng: 0.001 * rng.normal(size=(POINTS, 3)),
    "two balls apart": lambda rng: two_balls(rng),
}


def ring(rng: np.random.Generator, noise: float) -> np.ndarray:
    angle = rng.uniform(0, 2 * np.pi, POINTS)
    points = REACH * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(POINTS)])
    return points + noise * rng.normal(size=points.shape)


def two_balls(rng: np.random.Generator) -> np.ndarray:
    ball = rng.normal(size=(POINTS, 3))
    ball *= REACH / np.linalg.norm(ball, axis=1, keepdims=True)
    ball[::2] += [0.5, 0.0, 0.0]
    return ball


def usual_view(seed: int) -> CloudView:
    return one_view(*usual_solid(seed), np.random.default_rng([seed, 35]))


def assert_no_silent_failure(view: CloudView, seed: int) -> None:
    trial = try_fit(fit_method, view, seed)
    assert trial.clean, trial.note
    assert trial.refused or (trial.score or 0.0) >= FAILED, trial.note


@pytest.mark.parametrize("name", CHANGED_POINTS)
@pytest.mark.parametrize("seed", [0, 1])
def test_changed_points_give_no_silent_failure(name, seed):
    view = usual_view(seed)
    assert_no_silent_failure(replace(view, points=CHANGED_POINTS[name](view.points)), seed)


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("seed", [0, 1])
def test_wrong_camera_gives_no_silent_failure(name, seed):
    view = usual_view(seed)
    assert view.truth is not None
    assert view.view_origin is not None
    origin = CAMERAS[name](view.view_origin, view.truth.centre, view.points[0])
    assert_no_silent_failure(replace(view, view_origin=origin), seed)


@pytest.mark.parametrize("seed", [0, 1])
def test_support_plane_through_the_middle_gives_no_silent_failure(seed):
    view = usual_view(seed)
    assert view.truth is not None
    plane = np.array([0.0, 0.0, 1.0, -view.truth.centre[2]])
    assert_no_silent_failure(replace(view, support_plane=plane), seed)


@pytest.mark.parametrize("name", SHAPELESS)
@pytest.mark.parametrize("seed", [0, 1])
def test_solid_of_shapeless_points_stays_within_them(name, seed):
    points = SHAPELESS[name](np.random.default_rng([seed, 37]))
    trial = try_shapeless_points(fit_method, CloudView(points, view_origin=np.array([0, 0, 0.7])))
    assert trial.passed, trial.note

"""The extreme clouds of `eyehand stress fit`, by expectation: refuse, follow or degrade.

- ``refuse``: no usable solid, and a reason that names the fault.
- ``follow``: the same solid as for the usual cloud, moved with the cloud, to 1e-5 of its size.
- ``degrade``: no silent failure: an IoU of 50 % or more, or a refusal. For points of no solid, a
  solid that does not exceed the points.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from ...bench import Trial
from ...bench.stress_case import StressCase
from .clouds import POINTS
from .stress_trial import (
    FitCallable,
    try_following,
    try_no_silent_failure,
    try_refusal,
    try_shapeless_points,
)
from .stress_views import CloudView, moved, one_view, scaled, usual_solid

Points = NDArray[np.float64]
Extreme = StressCase[FitCallable]


COPIES = 100
"""Number of copies of repeated points."""
FAR = 1e4
"""Distance of far clouds from the origin, m."""
REACH = 0.05
"""Half extent of points that belong to no solid, m."""
TURN = Rotation.from_rotvec([0.5, -0.9, 1.3])
"""A rotation that moves every coordinate axis."""
FLATTEN = TURN.as_matrix() @ np.diag([1.0, 1.0, 0.0]) @ TURN.as_matrix().T
STRETCH = TURN.as_matrix() @ np.diag([1.0, 0.0, 0.0]) @ TURN.as_matrix().T
"""Projections onto a slanting plane and a slanting line."""


def extremes() -> tuple[Extreme, ...]:
    """Return all extreme clouds, in the order refuse, follow, degrade."""
    return (*_refused(), *_following(), *_degrading())


def _refused() -> list[Extreme]:
    on_points: list[tuple[str, str, Callable[[Points], Points]]] = [
        ("no points", "too few", lambda p: p[:0]),
        ("1 point", "too few", lambda p: p[:1]),
        ("49 points", "too few", lambda p: p[:49]),
        ("one point 1000 times", "same point", lambda p: p[:1].repeat(POINTS, axis=0)),
        ("2 points 100 times", "line", lambda p: p[:2].repeat(COPIES, axis=0)),
        ("10 points 100 times", "too few", lambda p: p[:10].repeat(COPIES, axis=0)),
        ("one NaN", "NaN or infinite", lambda p: _with(p, np.nan, 1)),
        ("one +inf", "NaN or infinite", lambda p: _with(p, np.inf, 1)),
        ("one -inf", "NaN or infinite", lambda p: _with(p, -np.inf, 1)),
        ("all NaN", "NaN or infinite", lambda p: _with(p, np.nan, len(p))),
        ("on a line along x", "line", lambda p: p * [1.0, 0.0, 0.0]),
        ("on a slanting line", "line", lambda p: p @ STRETCH),
        ("on a level plane", "plane", lambda p: p * [1.0, 1.0, 0.0]),
        ("on a slanting plane", "plane", lambda p: p @ FLATTEN),
    ]
    changed: list[tuple[str, str, Callable[[CloudView], CloudView]]] = [
        ("millimetres read as metres", "metres", lambda view: scaled(view, 1e3)),
        ("centimetres read as metres", "metres", lambda view: scaled(view, 1e2)),
        ("metres read as kilometres", "metres", lambda view: scaled(view, 1e-3)),
        ("coordinates of 1e300", "coordinates", lambda view: scaled(view, 1e300)),
        ("coordinates of 1e-300", "metres", lambda view: scaled(view, 1e-300)),
        ("wholly under its support plane", "support plane", lambda view: _over(view, 0.2)),
        ("100 m above its support plane", "support plane", lambda view: _over(view, -100.0)),
    ]
    changed = [(name, words, _on_points(make)) for name, words, make in on_points] + changed

    def extreme(name: str, words: str, change: Callable[[CloudView], CloudView]) -> Extreme:
        def attempt(seed: int, method: FitCallable) -> Trial:
            return try_refusal(method, change(_usual(seed)), words)

        return StressCase(name, "refuse", attempt, words)

    return [extreme(*row) for row in changed]


def _following() -> list[Extreme]:
    turns = {
        f"a quarter turn about {axis}": Rotation.from_euler(axis, 90, degrees=True)
        for axis in "xyz"
    }
    away = FAR * np.array([0.6, -0.64, 0.48])
    frames = {name: RigidTransform.from_rotation(turn) for name, turn in turns.items()} | {
        "a slanting turn": RigidTransform.from_rotation(TURN),
        "10 km from the origin": RigidTransform.from_translation(away),
        "turned, 10 km from the origin": RigidTransform.from_components(away, TURN),
    }
    stay = RigidTransform.identity()

    def extreme(
        name: str,
        T: RigidTransform,
        here: Callable[[int], CloudView],
        change: Callable[[CloudView], CloudView],
    ) -> Extreme:
        def attempt(seed: int, method: FitCallable) -> Trial:
            return try_following(method, here(seed), moved(change(here(seed)), T), T, seed)

        return StressCase(name, "follow", attempt)

    def larger(times: float) -> Callable[[CloudView], CloudView]:
        return lambda view: replace(scaled(view, times), unit=1.0 / times)

    return [
        *(extreme(name, T, _usual, lambda view: view) for name, T in frames.items()),
        *(
            extreme(f"{name}, on a table", T, _standing, lambda view: view)
            for name, T in frames.items()
        ),
        *(
            extreme(f"{times:g} times as large, options too", stay, _standing, larger(times))
            for times in (0.1, 0.5, 3.0, 10.0)
        ),
        extreme("in another order", stay, _usual, _on_points(lambda p: _shuffled(p))),
        extreme("transposed in memory", stay, _usual, _on_points(np.asfortranarray)),
    ]


def _degrading() -> list[Extreme]:
    changed: list[tuple[str, Callable[[CloudView], CloudView]]] = [
        ("50 points", _on_points(lambda p: p[:50])),
        ("rounded to 10 mm", _on_points(lambda p: p.round(2))),
        ("rounded to single precision 10 km away", _on_points(_coarse)),
        ("half of all points at one place", _on_points(_piled)),
        ("one point 1 m away", _on_points(lambda p: _stray(p, 1.0))),
        ("one point 100 km away", _on_points(lambda p: _stray(p, 1e5))),
        ("100 000 points", _on_points(_many)),
        ("camera inside the solid", lambda view: _from(view, _middle(view))),
        ("camera at a point", lambda view: _from(view, view.points[0])),
        ("camera 1000 km behind", lambda view: _from(view, 1e6 * _camera(view))),
        ("camera 1e300 m behind", lambda view: _from(view, 1e300 * _camera(view))),
        (
            "camera on the wrong side",
            lambda view: _from(view, 2 * _middle(view) - _camera(view)),
        ),
        ("support plane through the middle", lambda view: _over(view, 0.0)),
    ]
    shapeless: list[tuple[str, Callable[[np.random.Generator], Points]]] = [
        ("a filled ball of points", lambda rng: REACH * rng.normal(size=(POINTS, 3))),
        ("a filled cube of points", lambda rng: rng.uniform(-REACH, REACH, (POINTS, 3))),
        ("a ring of wire", lambda rng: _ring(rng, 0.0)),
        ("a ring of wire, 0.5 mm noise", lambda rng: _ring(rng, 0.0005)),
        ("the corners of a cube, 1 mm noise", _corners),
        ("one point 1000 times, 1 mm noise", lambda rng: 0.001 * rng.normal(size=(POINTS, 3))),
        ("two balls apart", _two_balls),
    ]

    def view_extreme(name: str, change: Callable[[CloudView], CloudView]) -> Extreme:
        def attempt(seed: int, method: FitCallable) -> Trial:
            return try_no_silent_failure(method, change(_usual(seed)), seed)

        return StressCase(name, "degrade", attempt)

    def shapeless_extreme(name: str, make: Callable[[np.random.Generator], Points]) -> Extreme:
        def attempt(seed: int, method: FitCallable) -> Trial:
            points = make(np.random.default_rng([seed, 37]))
            view = CloudView(points, view_origin=np.array([0.0, 0.0, 0.7]))
            return try_shapeless_points(method, view)

        return StressCase(name, "degrade", attempt)

    return [
        *(view_extreme(*row) for row in changed),
        *(shapeless_extreme(*row) for row in shapeless),
    ]


def _usual(seed: int) -> CloudView:
    return one_view(*usual_solid(seed), np.random.default_rng([seed, 35]))


def _standing(seed: int) -> CloudView:
    """Return the usual view with a support plane that touches the solid from below."""
    view = _usual(seed)
    assert view.truth is not None
    lowest = -float(view.truth.support(np.array([0.0, 0.0, -1.0])))
    return replace(view, support_plane=np.array([0.0, 0.0, 1.0, -lowest]))


def _on_points(change: Callable[[Points], Points]) -> Callable[[CloudView], CloudView]:
    return lambda view: replace(view, points=change(view.points))


def _over(view: CloudView, height: float) -> CloudView:
    """Add a horizontal support plane at a height above the centre of the solid."""
    plane = np.array([0.0, 0.0, 1.0, -_middle(view)[2] - height])
    return replace(view, support_plane=plane)


def _from(view: CloudView, origin: NDArray[np.float64]) -> CloudView:
    return replace(view, view_origin=origin)


def _middle(view: CloudView) -> NDArray[np.float64]:
    assert view.truth is not None
    return view.truth.centre


def _camera(view: CloudView) -> NDArray[np.float64]:
    assert view.view_origin is not None
    return view.view_origin


def _with(points: Points, value: float, count: int) -> Points:
    points = points.copy()
    points[:count, 1] = value
    return points


def _shuffled(points: Points) -> Points:
    return np.random.default_rng(0).permutation(points)


def _stray(points: Points, away: float) -> Points:
    """Add a point far from the others."""
    return np.vstack([points, points[:1] + np.array([away, 0.0, 0.0])])


def _coarse(points: Points) -> Points:
    return (points + FAR).astype(np.float32).astype(np.float64) - FAR


def _piled(points: Points) -> Points:
    half = len(points) // 2
    return np.vstack([points[:half], points[:1].repeat(half, axis=0)])


def _many(points: Points) -> Points:
    rng = np.random.default_rng(0)
    many = points.repeat(COPIES, axis=0)
    return many + 0.0005 * rng.normal(size=many.shape)


def _ring(rng: np.random.Generator, noise: float) -> Points:
    angle = rng.uniform(0, 2 * np.pi, POINTS)
    ring = REACH * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(POINTS)])
    return ring + noise * rng.normal(size=ring.shape)


def _corners(rng: np.random.Generator) -> Points:
    corners = REACH * rng.choice([-1.0, 1.0], (POINTS, 3))
    return corners + 0.001 * rng.normal(size=corners.shape)


def _two_balls(rng: np.random.Generator) -> Points:
    ball = rng.normal(size=(POINTS, 3))
    ball *= REACH / np.linalg.norm(ball, axis=1, keepdims=True)
    ball[::2] += [0.5, 0.0, 0.0]
    return ball

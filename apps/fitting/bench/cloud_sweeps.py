"""Sweeps in which clouds get worse: fewer points, more noise, more outliers, less to be seen."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception.superquadric import sample_surface

from ...bench import Sweep, Trial
from .clouds import DEFAULT_NOISE, DISTANCE, POINTS
from .stress_trial import RIGHT, FitCallable, try_fit, try_following, try_refusal
from .stress_views import Look, moved, one_view, usual_solid

if TYPE_CHECKING:
    from numpy.typing import NDArray

MM = 1e-3
MIN_POINTS = 50
"""Clouds of fewer points must be refused by name."""
OUTLIER_REACH = 2.0
"""Outliers lie anywhere in the solid's bounds times this."""
FINE = f"IoU of {100 * RIGHT:.0f} % or more"
TOWARDS_FAR = np.array([0.6, -0.64, 0.48])
"""Where clouds far from the origin lie."""


def cloud_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Sweeps of point count, noise, outliers, share of the surface seen, and distance."""
    return (
        Sweep(
            name="points",
            axis="points of one view",
            unit="",
            values=(1000, 500, 300, 200, 150, 100, 70, 50, 40, 30, 20, 10),
            holds_to=100,
            attempt=_points,
            right=f"{FINE}; below {MIN_POINTS} points refused by name",
        ),
        Sweep(
            name="noise",
            axis="noise of each coordinate",
            unit="mm",
            values=(0, 0.5, 1, 2, 3, 4, 5, 7, 10),
            holds_to=2,
            attempt=_noise,
            right=FINE,
        ),
        Sweep(
            name="outliers",
            axis="points anywhere around, of one view's",
            unit="%",
            values=(0, 5, 10, 20, 30, 40, 50, 60),
            holds_to=30,
            attempt=_outliers,
            right=FINE,
        ),
        Sweep(
            name="seen",
            axis="share of the whole surface seen, camera unknown",
            unit="%",
            values=(100, 80, 60, 50, 40, 30, 20, 10),
            holds_to=50,
            attempt=_seen,
            right=FINE,
        ),
        Sweep(
            name="occluded",
            axis="share of one view that is not hidden",
            unit="%",
            values=(100, 80, 60, 50, 40, 30, 20, 10),
            holds_to=80,
            attempt=_occluded,
            right=FINE,
        ),
        Sweep(
            name="far",
            axis="cloud's distance from the origin",
            unit="m",
            values=(1, 10, 100, 1000, 10_000, 100_000, 1_000_000),
            holds_to=10_000,
            attempt=_far,
            right="the same solid there, to 1e-5 of its size",
        ),
    )


def _points(count: float, seed: int, method: FitCallable) -> Trial:
    look = one_view(*usual_solid(seed), _random(seed, 1), count=int(count))
    if count < MIN_POINTS:
        return try_refusal(method, look, f"{count:.0f} points are too few")
    return try_fit(method, look, seed)


def _noise(sigma: float, seed: int, method: FitCallable) -> Trial:
    look = one_view(*usual_solid(seed), _random(seed, 2), noise=sigma * MM)
    return try_fit(method, look, seed)


def _outliers(share: float, seed: int, method: FitCallable) -> Trial:
    rng = _random(seed, 3)
    solid, origin = usual_solid(seed)
    look = one_view(solid, origin, rng)
    low, high = -solid.support(-np.eye(3)), solid.support(np.eye(3))
    middle, half = (low + high) / 2, OUTLIER_REACH * (high - low) / 2
    # Points are in random order: the first are any.
    wrong = round(share / 100 * len(look.points))
    look.points[:wrong] = middle + half * rng.uniform(-1, 1, (wrong, 3))
    return try_fit(method, look, seed)


def _seen(share: float, seed: int, method: FitCallable) -> Trial:
    """Of the whole surface, the share that lies farthest along some direction."""
    rng = _random(seed, 4)
    solid, origin = usual_solid(seed)
    points = sample_surface(solid, round(POINTS * 100 / share), rng)
    order = np.argsort(points @ (solid.centre - origin))
    points = points[order[:POINTS]] + DEFAULT_NOISE * rng.normal(size=(POINTS, 3))
    return try_fit(method, Look(points, solid), seed)


def _occluded(share: float, seed: int, method: FitCallable) -> Trial:
    """One view, of which something with a straight edge leaves but a share; the edge is known."""
    rng = _random(seed, 5)
    solid, origin = usual_solid(seed)
    look = one_view(solid, origin, rng, count=round(POINTS * 100 / share))
    forward = (solid.centre - origin) / DISTANCE
    edge = np.cross(forward, rng.normal(size=3))
    edge /= np.linalg.norm(edge)

    def beside(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return (points - origin) @ edge / ((points - origin) @ forward)

    limit = np.quantile(beside(look.points), share / 100)

    def hidden(directions: NDArray[np.float64]) -> NDArray[np.bool_]:
        return beside(origin + directions) > limit

    left = look.points[beside(look.points) <= limit]
    return try_fit(method, Look(left, solid, origin, hidden=hidden), seed)


def _far(distance: float, seed: int, method: FitCallable) -> Trial:
    look = _at_home(seed)
    T = RigidTransform.from_translation(distance * TOWARDS_FAR)
    return try_following(method, look, moved(look, T), T, seed)


@functools.cache
def _at_home(seed: int) -> Look:
    return one_view(*usual_solid(seed), _random(seed, 6))


def _random(seed: int, sweep: int) -> np.random.Generator:
    return np.random.default_rng([seed, 29, sweep])

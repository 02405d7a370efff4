"""Stress sweeps over worse clouds: fewer points, noise, outliers, occlusion, distance."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.perception.superquadric import sample_surface

from ...bench import Sweep, Trial
from .clouds import DEFAULT_NOISE, DISTANCE, POINTS, uniform_outliers
from .stress_trial import RIGHT, FitCallable, try_fit, try_following, try_refusal
from .stress_views import CloudView, free_space_around, moved, one_view, usual_solid

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    SweepRow = tuple[
        str, str, str, tuple[float, ...], float, Callable[[float, int, FitCallable], Trial]
    ]
    """Name, quantity that gets harder, its unit, its values, the bound, and the trial."""

MM = 1e-3
MIN_POINTS = 50
"""Minimum number of points. A fit must refuse smaller clouds by name."""
OUTLIER_SCALE = 2.0
"""Size of the box of the outliers, relative to the bounds of the solid."""
ACCURATE = f"IoU of {100 * RIGHT:.0f} % or more"
FAR_DIRECTION = np.array([0.6, -0.64, 0.48])
"""Unit vector from the origin to far clouds."""


def cloud_sweeps() -> tuple[Sweep[FitCallable], ...]:
    """Return the sweeps of point count, noise, outliers, visible share and distance."""
    shares = (100, 80, 60, 50, 40, 30, 20, 10)
    return (
        Sweep(
            name="points",
            axis="points of one view",
            unit="",
            values=(1000, 500, 300, 200, 150, 100, 70, 50, 40, 30, 20, 10),
            holds_to=100,
            attempt=_points,
            right=f"{ACCURATE}; below {MIN_POINTS} points refused by name",
        ),
        *accuracy_sweeps(
            [
                ("noise", "noise per coordinate", "mm", (0, 0.5, 1, 2, 3, 4, 5, 7, 10), 2, _noise),
                (
                    "outliers",
                    "share of outliers",
                    "%",
                    (0, 5, 10, 20, 30, 40, 50, 60),
                    30,
                    _outliers,
                ),
                ("seen", "share of the surface, unknown camera", "%", shares, 50, _surface_share),
                ("occluded", "share of one view that is not hidden", "%", shares, 80, _occluded),
            ]
        ),
        Sweep(
            name="far",
            axis="distance of the cloud from the origin",
            unit="m",
            values=(1, 10, 100, 1000, 10_000, 100_000, 1_000_000),
            holds_to=10_000,
            attempt=_far,
            right="the same solid as near the origin, to 1e-5 of its size",
        ),
    )


def accuracy_sweeps(rows: Iterable[SweepRow]) -> list[Sweep[FitCallable]]:
    """Return sweeps whose trials pass with an accurate solid."""
    return [Sweep(*row, right=ACCURATE) for row in rows]


def _points(count: float, seed: int, method: FitCallable) -> Trial:
    view = one_view(*usual_solid(seed), _rng(seed, 1), count=int(count))
    if count < MIN_POINTS:
        return try_refusal(method, view, f"{count:.0f} points are too few")
    return try_fit(method, view, seed)


def _noise(sigma_mm: float, seed: int, method: FitCallable) -> Trial:
    view = one_view(*usual_solid(seed), _rng(seed, 2), noise=sigma_mm * MM)
    return try_fit(method, view, seed)


def _outliers(share_pct: float, seed: int, method: FitCallable) -> Trial:
    rng = _rng(seed, 3)
    solid, origin = usual_solid(seed)
    view = one_view(solid, origin, rng)
    # The points are in random order, so the first ones are a fair sample.
    count = round(share_pct / 100 * len(view.points))
    view.points[:count] = uniform_outliers(solid, OUTLIER_SCALE, count, rng)
    return try_fit(method, view, seed)


def _surface_share(share_pct: float, seed: int, method: FitCallable) -> Trial:
    """Fit the given share of the whole surface: the part nearest to one side."""
    rng = _rng(seed, 4)
    solid, origin = usual_solid(seed)
    points = sample_surface(solid, round(POINTS * 100 / share_pct), rng)
    order = np.argsort(points @ (solid.centre - origin))
    points = points[order[:POINTS]] + DEFAULT_NOISE * rng.normal(size=(POINTS, 3))
    return try_fit(method, CloudView(points, solid), seed)


def _occluded(share_pct: float, seed: int, method: FitCallable) -> Trial:
    """Fit one view behind an occluder with a straight edge, whose position is known."""
    rng = _rng(seed, 5)
    solid, origin = usual_solid(seed)
    view = one_view(solid, origin, rng, count=round(POINTS * 100 / share_pct))
    forward = (solid.centre - origin) / DISTANCE
    across = np.cross(forward, rng.normal(size=3))
    across /= np.linalg.norm(across)

    def offset(points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the image coordinate (N,) across the edge."""
        return (points - origin) @ across / ((points - origin) @ forward)

    edge = np.quantile(offset(view.points), share_pct / 100)
    visible = view.points[offset(view.points) <= edge]
    free_space = free_space_around(view.points, origin)
    behind = offset(origin + free_space.rays) > edge
    free_space = replace(
        free_space,
        depth=np.where(behind, 0.5 * DISTANCE, free_space.depth),
        on_object=free_space.on_object & ~behind,
    )
    return try_fit(method, CloudView(visible, solid, origin, free_space=free_space), seed)


def _far(distance: float, seed: int, method: FitCallable) -> Trial:
    view = _near_view(seed)
    T = RigidTransform.from_translation(distance * FAR_DIRECTION)
    return try_following(method, view, moved(view, T), T, seed)


@functools.cache
def _near_view(seed: int) -> CloudView:
    return one_view(*usual_solid(seed), _rng(seed, 6))


def _rng(seed: int, sweep: int) -> np.random.Generator:
    return np.random.default_rng([seed, 29, sweep])

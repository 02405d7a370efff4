"""A felt cloud held to the true surface: how far off, and how much of what could be reached."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import ConvexHull, KDTree

from eyehand.data_synth.pad import surface_distance, top_surface

from .explore_run import MAX_TILT_DEG

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.data_synth.pad import TouchObject

    from .explore_run import ExploreRun

GRID = 0.002
"""Between points of the true surface seen from above, m."""
HALF_PLAN = (0.104, 0.074)
"""Half the plan that is looked at, m: a little more than the object."""
HOLLOW = 0.0003
"""Below the convex hull a large flat pad reaches no deeper than this, m: its foam's give."""
SHADOW = 0.05
"""How far below the top what closes its hull lies, m."""
BLUR, NARROW = 0.0025, 0.0001
"""Where a blur of the surface by this much would sink it by as much as this, m, it is a ridge, an
edge or a corner."""
NEAR = 0.005
"""A surface point with a felt point as near as this is covered, m: the pad's pitch."""


@cache
def height_map(thing: TouchObject) -> tuple[NDArray[np.float64], NDArray[np.float64], Any]:
    """Give x (C,), y (R,) and the height (R, C) of an object's top, m; NaN beside it."""
    x = np.arange(-HALF_PLAN[0], HALF_PLAN[0] + GRID / 2, GRID)
    y = np.arange(-HALF_PLAN[1], HALF_PLAN[1] + GRID / 2, GRID)
    across, up = np.meshgrid(x, y)
    return x, y, top_surface(thing, across.ravel(), up.ravel()).reshape(across.shape)


def reachable_surface(thing: TouchObject) -> NDArray[np.float64]:
    """Give points (M, 3) of the top that a flat pad tilted no further than allowed can touch."""
    x, y, heights = height_map(thing)
    across, up = np.meshgrid(x, y)
    top = np.column_stack([across.ravel(), up.ravel(), heights.ravel()])
    top = top[np.isfinite(top[:, 2])]
    # With its shadow below it, a flat top has a hull, too.
    planes = ConvexHull(np.concatenate([top, top - [0.0, 0.0, SHADOW]])).equations
    planes = planes[planes[:, 2] > 1e-6]
    over = -(planes[:, :2] @ top[:, :2].T + planes[:, 3:]) / planes[:, 2:3]
    facet = over.argmin(axis=0)
    hull = over.min(axis=0)
    steep = planes[facet, 2] < np.cos(np.radians(MAX_TILT_DEG))
    return top[(hull - top[:, 2] < HOLLOW) & ~steep]


def on_ridges(thing: TouchObject, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell which points (M, 3) are nearest to a ridge, an edge or a corner of the true top."""
    from scipy.ndimage import gaussian_filter

    x, y, heights = height_map(thing)
    known = np.isfinite(heights)
    sigma = BLUR / GRID
    # Weighted by what is there: beside the object there is no height to blur with.
    share = np.maximum(gaussian_filter(known.astype(float), sigma), 1e-9)
    smooth = gaussian_filter(np.where(known, heights, 0.0), sigma) / share
    narrow = known & (heights - smooth > NARROW)
    across, up = np.meshgrid(x, y)
    top = np.column_stack([across.ravel(), up.ravel(), heights.ravel()])[known.ravel()]
    return narrow.ravel()[known.ravel()][KDTree(top).query(points)[1]]


def explore_rows(run: ExploreRun) -> list[dict[str, Any]]:
    """Give the figures of each pad's cloud, of both, and of both as the blurred images give it."""
    surface = reachable_surface(run.thing)
    felt, blurred = _judged(run.thing, run.points), _judged(run.thing, run.blurred)
    left, right = run.pad == 0, run.pad == 1
    clouds = {
        "left pad": (felt[0][left], felt[1][left], felt[2][left]),
        "right pad": (felt[0][right], felt[1][right], felt[2][right]),
        "both, blurred": blurred,
        "both": felt,
    }
    return [_row(name, *cloud, surface) for name, cloud in clouds.items() if len(cloud[0])]


def _judged(
    thing: TouchObject, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Give points with the distance of each to the surface, mm, and whether it is on a ridge."""
    return points, 1e3 * surface_distance(thing, points), on_ridges(thing, points)


def _row(
    name: str,
    points: NDArray[np.float64],
    errors: NDArray[np.float64],
    on_ridge: NDArray[np.bool_],
    surface: NDArray[np.float64],
) -> dict[str, Any]:
    ridges = errors[on_ridge]
    return {
        "name": name,
        "points": len(points),
        "surface_rms_mm": float(np.sqrt(np.mean(errors**2))),
        "surface_median_mm": float(np.median(errors)),
        "surface_p95_mm": float(np.percentile(np.abs(errors), 95)),
        # A smooth object may have none.
        "ridges_rms_mm": float(np.sqrt(np.mean(ridges**2))) if len(ridges) else 0.0,
        "ridges_median_mm": float(np.median(ridges)) if len(ridges) else 0.0,
        "ridges_points": len(ridges),
        "covered_pct": 100 * float(np.mean(KDTree(points).query(surface)[0] < NEAR)),
    }

"""Compare a measured point cloud with the true surface: distance and coverage."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, KDTree

from eyehand.data_synth.pad import TouchObject, surface_distance, top_surface

from .explore_run import MAX_TILT_DEG, ExploreRun

GRID = 0.002
"""Grid spacing of the true surface from above, m."""
HALF_PLAN = (0.104, 0.074)
"""Half side lengths of the evaluated plan, m: slightly more than the object."""
HOLLOW = 0.0003
"""Maximum depth below the convex hull that a large flat pad reaches, m. Its foam yields so far."""
SHADOW = 0.05
"""Depth of the copy of the top that closes its hull, m."""
BLUR, NARROW = 0.0025, 0.0001
"""Standard deviation of a blur of the surface, and the lowering by it, m. A point that is lowered
by more lies on a ridge, an edge or a corner."""
NEAR = 0.005
"""Maximum distance between a covered surface point and a measured point, m: the pad's pitch."""


@cache
def height_map(touch_object: TouchObject) -> tuple[NDArray[np.float64], NDArray[np.float64], Any]:
    """Return x (C,), y (R,) and the height (R, C) of an object's top, m. NaN beside the object."""
    x = np.arange(-HALF_PLAN[0], HALF_PLAN[0] + GRID / 2, GRID)
    y = np.arange(-HALF_PLAN[1], HALF_PLAN[1] + GRID / 2, GRID)
    across, up = np.meshgrid(x, y)
    return x, y, top_surface(touch_object, across.ravel(), up.ravel()).reshape(across.shape)


def reachable_surface(touch_object: TouchObject) -> NDArray[np.float64]:
    """Return the points (M, 3) of the top that a flat pad can touch within its tilt limit, m."""
    x, y, heights = height_map(touch_object)
    across, up = np.meshgrid(x, y)
    top = np.column_stack([across.ravel(), up.ravel(), heights.ravel()])
    top = top[np.isfinite(top[:, 2])]
    # A copy of the points below the top gives a flat top a hull with volume.
    planes = ConvexHull(np.concatenate([top, top - [0.0, 0.0, SHADOW]])).equations
    planes = planes[planes[:, 2] > 1e-6]
    over = -(planes[:, :2] @ top[:, :2].T + planes[:, 3:]) / planes[:, 2:3]
    facet = over.argmin(axis=0)
    hull = over.min(axis=0)
    steep = planes[facet, 2] < np.cos(np.radians(MAX_TILT_DEG))
    return top[(hull - top[:, 2] < HOLLOW) & ~steep]


def on_ridges(touch_object: TouchObject, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (M,) of the points (M, 3) whose nearest true point is on a ridge or edge."""
    from scipy.ndimage import gaussian_filter

    x, y, heights = height_map(touch_object)
    known = np.isfinite(heights)
    sigma = BLUR / GRID
    # The blur is normalised by the known heights because there is no height beside the object.
    share = np.maximum(gaussian_filter(known.astype(float), sigma), 1e-9)
    smooth = gaussian_filter(np.where(known, heights, 0.0), sigma) / share
    narrow = known & (heights - smooth > NARROW)
    across, up = np.meshgrid(x, y)
    top = np.column_stack([across.ravel(), up.ravel(), heights.ravel()])[known.ravel()]
    return narrow.ravel()[known.ravel()][KDTree(top).query(points)[1]]


def explore_rows(run: ExploreRun) -> list[dict[str, Any]]:
    """Compute the figures for each pad, both pads, and both pads without deconvolution."""
    surface = reachable_surface(run.touch_object)
    felt, blurred = (
        _compared(run.touch_object, run.points),
        _compared(run.touch_object, run.blurred),
    )
    left, right = run.pad == 0, run.pad == 1
    clouds = {
        "left pad": (felt[0][left], felt[1][left], felt[2][left]),
        "right pad": (felt[0][right], felt[1][right], felt[2][right]),
        "both, blurred": blurred,
        "both": felt,
    }
    return [_row(name, *cloud, surface) for name, cloud in clouds.items() if len(cloud[0])]


def _compared(
    touch_object: TouchObject, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return the points, their signed distances to the surface, mm, and the mask of ridges."""
    return points, 1e3 * surface_distance(touch_object, points), on_ridges(touch_object, points)


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

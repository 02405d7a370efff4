"""From a fit to what its picture shows: points, colours, solids, three views."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.perception.superquadric import feature_curves, mesh

from ..bench.chart_style import BLUE, GREY, VERMILION
from ..scene_json import fit_parts
from .picture_parts import PictureScene, View

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .fit_inputs import Cloud, FittedCloud

DRAWN_POINTS = 4000
"""More points hide one another."""
RESOLUTION = 96
"""Points around the drawn mesh."""
NICE_MM = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50, 100, 200, 500)
"""Where the colour scale may end."""
COLOURED_PCT = 90.0
"""Share of the points within the colour scale; those beyond keep its last colour."""
VIVID = 0.7
"""Power of the distance by which colours leave grey: below 1 small distances show, too."""
FRAMED_PCT = 99.5
"""Share of the points that a view must hold: stray ones do not make the object small."""
BORDER = 1.08
"""Half the side of a view, in half extents of what it shows."""
SMALLEST_HALF = 1e-3
"""Half the side of a view of a single point, m."""
STEEP = 0.15
"""A camera this near to straight above (cosine) does not say where the front is."""


def picture_scene(fitted: FittedCloud) -> PictureScene:
    """Collect what a picture of a fit shows."""
    cloud = fitted.cloud
    parts = fit_parts(fitted.fit)
    points = thinned(cloud.points, DRAWN_POINTS)
    nearest, residuals = residual_to(points, parts)
    facing = np.zeros_like(points)
    for number, part in enumerate(parts):
        facing[nearest == number] = part.normals(points[nearest == number])
    limit = colour_limit_mm(residuals) if parts else 0.0
    surfaces = [mesh(part, RESOLUTION) for part in parts]
    views = picture_views(cloud)
    solid = np.concatenate([vertices for vertices, _ in surfaces] or [points])
    middle, half = _framed(points, solid, views)
    lines = [(part, curve) for part in parts for curve in feature_curves(part)]
    return PictureScene(
        points - middle,
        residual_colours(residuals, limit),
        facing,
        limit,
        tuple((vertices - middle, faces) for vertices, faces in surfaces),
        tuple(curve - middle for _, curve in lines),
        tuple(part.normals(curve) for part, curve in lines),
        views,
        half,
    )


def thinned(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most `most` of the points, always the same ones."""
    if len(points) <= most:
        return points
    return points[np.sort(np.random.default_rng(0).choice(len(points), most, replace=False))]


def residual_to(
    points: NDArray[np.float64], parts: Sequence[Superquadric]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Nearest solid's number (N,) and the signed distance to it (N,), m; 0 without solids."""
    if not parts:
        return np.zeros(len(points), np.intp), np.zeros(len(points))
    distances = np.array([part.distance(points) for part in parts])
    nearest = np.abs(distances).argmin(axis=0)
    return nearest, distances[nearest, np.arange(len(points))]


def colour_limit_mm(residuals: NDArray[np.float64]) -> float:
    """End of the colour scale for distances in m: a round number of mm that holds most."""
    reach = 1e3 * float(np.percentile(np.abs(residuals), COLOURED_PCT))
    return next((nice for nice in NICE_MM if nice >= reach), NICE_MM[-1])


def residual_colours(residuals: NDArray[np.float64], limit_mm: float) -> NDArray[np.float64]:
    """Colours (N, 3), 0-1, of distances in m; all grey where the limit is 0."""
    inside, on, outside = (_rgb(colour) for colour in (BLUE, GREY, VERMILION))
    if limit_mm <= 0:
        return np.broadcast_to(on, (len(residuals), 3)).copy()
    t = np.clip(1e3 * residuals / limit_mm, -1.0, 1.0)[:, None]
    t = np.sign(t) * np.abs(t) ** VIVID
    return on + np.where(t < 0, -t * (inside - on), t * (outside - on))


def picture_views(cloud: Cloud) -> tuple[View, View, View]:
    """Choose the three sides: the camera's is the front and the support is below, where known."""
    up = up_direction(cloud)
    towards = np.zeros(3)
    if cloud.view_origin is not None:
        towards = cloud.view_origin - cloud.points.mean(axis=0)
        towards = towards / max(float(np.linalg.norm(towards)), np.finfo(float).tiny)
    if float(np.linalg.norm(np.cross(up, towards))) < STEEP:
        axes = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
        towards = next(axis for axis in axes if abs(axis @ up) < np.sqrt(0.5))
    towards = towards - (towards @ up) * up
    towards = towards / np.linalg.norm(towards)
    right: NDArray[np.float64] = np.cross(up, towards)
    return View("front", right, up), View("side", -towards, up), View("top", right, -towards)


def up_direction(cloud: Cloud) -> NDArray[np.float64]:
    """Away from the support; without one against y in a camera's own frame, else z, (3,)."""
    if cloud.support_plane is not None:
        return cloud.support_plane[:3]
    if cloud.view_origin is not None and not np.any(cloud.view_origin):
        return np.array([0.0, -1.0, 0.0])
    return np.array([0.0, 0.0, 1.0])


def _framed(
    points: NDArray[np.float64], solid: NDArray[np.float64], views: Sequence[View]
) -> tuple[NDArray[np.float64], float]:
    """Middle (3,) and half side of what is shown, m."""
    axes = np.array([views[0].right, views[0].up, views[0].towards])
    tail = (100.0 - FRAMED_PCT) / 2
    low, high = np.percentile(points @ axes.T, [tail, 100.0 - tail], axis=0)
    low = np.minimum(low, (solid @ axes.T).min(axis=0))
    high = np.maximum(high, (solid @ axes.T).max(axis=0))
    half = max(float((high - low).max()) / 2, SMALLEST_HALF)
    return 0.5 * (low + high) @ axes, BORDER * half


def _rgb(colour: str) -> NDArray[np.float64]:
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0

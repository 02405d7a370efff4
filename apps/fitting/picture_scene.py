"""Compute what the picture of a fit shows: points, colours, solids and three views."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..bench.chart_style import BLUE, GREY, VERMILION
from ..drawn_solids import drawn_solids, solid_curves, solid_mesh

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric
    from eyehand.perception.superquadric import Vessel

    from .fit_inputs import Cloud, FittedCloud

MAX_POINTS = 4000
"""Maximum number of drawn points. More points would cover one another."""
RESOLUTION = 96
"""Points around the drawn mesh."""
COLOUR_LIMITS_MM = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50, 100, 200, 500)
"""Possible ends of the colour scale."""
COLOURED_PCT = 90.0
"""Percentage of the points within the colour scale. The others have its end colours."""
COLOUR_POWER = 0.7
"""Exponent of the distance in the colour. Below 1, small distances are visible too."""
FRAMED_PCT = 99.5
"""Percentage of the points that a view contains. Stray points would make the object small."""
BORDER = 1.08
"""Ratio of the half side of a view to the largest half extent of its contents."""
MIN_HALF_SIDE = 1e-3
"""Minimum half side of a view, m, for clouds without extent."""
MIN_CAMERA_SINE = 0.15
"""Sine of the angle between camera and vertical below which the camera does not define the
front."""


@dataclass(frozen=True)
class View:
    """An orthographic view."""

    name: str
    """front, side or top."""
    right: NDArray[np.float64]
    """Right direction of the picture, (3,)."""
    up: NDArray[np.float64]
    """Up direction of the picture, (3,)."""

    @property
    def towards(self) -> NDArray[np.float64]:
        """Direction towards the viewer, (3,)."""
        return np.cross(self.right, self.up)

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Project points (..., 3) to the picture plane, (..., 2), m."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


@dataclass(frozen=True)
class PictureScene:
    """Everything that is drawn, relative to the middle of the picture, m."""

    points: NDArray[np.float64]
    """Drawn points (N, 3)."""
    colours: NDArray[np.float64]
    """RGB colours (N, 3), 0 to 1: blue inside the solid, red outside, grey on it."""
    facing: NDArray[np.float64]
    """Outward unit normals (N, 3) of the solid at the points; 0 without a solid."""
    limit_mm: float
    """Distance at the end of the colour scale; 0 without a solid."""
    surfaces: tuple[tuple[NDArray[np.float64], NDArray[np.int64]], ...]
    """Vertices (V, 3) and faces (T, 3) of each solid."""
    curves: tuple[NDArray[np.float64], ...]
    """Feature lines, (K, 3) each."""
    normals: tuple[NDArray[np.float64], ...]
    """Outward unit normals of the solids at the feature lines, (K, 3) each."""
    views: tuple[View, View, View]
    """Front, side, top."""
    half: float
    """Half side of every view, m."""


def picture_scene(fitted: FittedCloud) -> PictureScene:
    """Collect what the picture of a fit shows."""
    cloud = fitted.cloud
    parts = drawn_solids(fitted.fit)
    points = thinned(cloud.points, MAX_POINTS)
    nearest, residuals = residual_to(points, parts)
    facing = np.zeros_like(points)
    for number, part in enumerate(parts):
        facing[nearest == number] = part.normals(points[nearest == number])
    limit = colour_limit_mm(residuals) if parts else 0.0
    surfaces = [solid_mesh(part, RESOLUTION) for part in parts]
    views = picture_views(cloud)
    solid = np.concatenate([vertices for vertices, _ in surfaces] or [points])
    middle, half = _framed(points, solid, views)
    lines = [(part, curve) for part in parts for curve in solid_curves(part)]
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


def thinned(points: NDArray[np.float64], max_points: int) -> NDArray[np.float64]:
    """Return at most `max_points` of the points (N, 3), always the same ones."""
    if len(points) <= max_points:
        return points
    chosen = np.random.default_rng(0).choice(len(points), max_points, replace=False)
    return points[np.sort(chosen)]


def residual_to(
    points: NDArray[np.float64], parts: Sequence[Superquadric | Vessel]
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Return the number (N,) of the nearest solid and the signed distance to it (N,), m.

    Both are 0 without solids.
    """
    if not parts:
        return np.zeros(len(points), np.intp), np.zeros(len(points))
    distances = np.array([part.distance(points) for part in parts])
    nearest = np.abs(distances).argmin(axis=0)
    return nearest, distances[nearest, np.arange(len(points))]


def colour_limit_mm(residuals: NDArray[np.float64]) -> float:
    """Return the end of the colour scale, mm, for distances (N,) in m: a round number."""
    reach = 1e3 * float(np.percentile(np.abs(residuals), COLOURED_PCT))
    return next((limit for limit in COLOUR_LIMITS_MM if limit >= reach), COLOUR_LIMITS_MM[-1])


def residual_colours(residuals: NDArray[np.float64], limit_mm: float) -> NDArray[np.float64]:
    """Return the colours (N, 3), 0 to 1, of distances (N,) in m; all grey if the limit is 0."""
    inside, on, outside = (np.array(rgb(colour)) / 255.0 for colour in (BLUE, GREY, VERMILION))
    if limit_mm <= 0:
        return np.broadcast_to(on, (len(residuals), 3)).copy()
    t = np.clip(1e3 * residuals / limit_mm, -1.0, 1.0)[:, None]
    t = np.sign(t) * np.abs(t) ** COLOUR_POWER
    return on + np.where(t < 0, -t * (inside - on), t * (outside - on))


def rgb(colour: str) -> tuple[int, int, int]:
    """Convert a colour such as ``#8DB3D9`` to red, green and blue, 0 to 255."""
    red, green, blue = bytes.fromhex(colour[1:])
    return red, green, blue


def picture_views(cloud: Cloud) -> tuple[View, View, View]:
    """Return front, side and top view. The front faces the camera, and the support is below."""
    up = up_direction(cloud)
    towards = np.zeros(3)
    if cloud.view_origin is not None:
        towards = cloud.view_origin - cloud.points.mean(axis=0)
        towards = towards / max(float(np.linalg.norm(towards)), np.finfo(float).tiny)
    if float(np.linalg.norm(np.cross(up, towards))) < MIN_CAMERA_SINE:
        axes = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
        towards = next(axis for axis in axes if abs(axis @ up) < np.sqrt(0.5))
    towards = towards - (towards @ up) * up
    towards = towards / np.linalg.norm(towards)
    right: NDArray[np.float64] = np.cross(up, towards)
    return View("front", right, up), View("side", -towards, up), View("top", right, -towards)


def up_direction(cloud: Cloud) -> NDArray[np.float64]:
    """Return the up direction (3,): the normal of the support plane if it is known.

    Otherwise it is -y in a camera frame, and z in other frames.
    """
    if cloud.support_plane is not None:
        return cloud.support_plane[:3]
    if cloud.view_origin is not None and not np.any(cloud.view_origin):
        return np.array([0.0, -1.0, 0.0])
    return np.array([0.0, 0.0, 1.0])


def _framed(
    points: NDArray[np.float64], solid: NDArray[np.float64], views: Sequence[View]
) -> tuple[NDArray[np.float64], float]:
    """Return the middle (3,) and the half side of the views, m."""
    axes = np.array([views[0].right, views[0].up, views[0].towards])
    tail = (100.0 - FRAMED_PCT) / 2
    low, high = np.percentile(points @ axes.T, [tail, 100.0 - tail], axis=0)
    low = np.minimum(low, (solid @ axes.T).min(axis=0))
    high = np.maximum(high, (solid @ axes.T).max(axis=0))
    half = max(float((high - low).max()) / 2, MIN_HALF_SIDE)
    return 0.5 * (low + high) @ axes, BORDER * half

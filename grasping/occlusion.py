"""The space behind an object that a camera cannot see past it."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, SuperquadricFit, SupportPlane

POINTS = 60
"""Points on a round solid that stand for it: some 25° apart."""
RIM_POINTS = 16
"""Points on either rim of a cylinder."""
MOST_POINTS = 150
"""Most points of an object without a solid, and directions in which they are the farthest ones."""
DIRECTIONS = 96
"""Directions in which a gap between two objects is looked for."""
TABLE_SKIN = 0.001
"""Unseen space ends so far above the table, m."""


class Gap(NamedTuple):
    """A slab between two things that touches both."""

    normal: NDArray[np.float64]
    """Unit direction (3,) across it, away from the second thing."""
    start: float
    """Coordinate along the normal at which the second thing ends, m."""
    width: float
    """Thickness, m; negative when they overlap in every direction tried."""


def outline(item: SceneObject) -> NDArray[np.float64]:
    """Points (N, 3), m, whose hull is about the object: of its solid, else of what was seen."""
    if item.fit.superquadric is None or not item.fit:
        return extremes(item.points)
    return _outline(item.fit)


def extremes(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Choose of many points (N, 3) those farthest in some direction: about the same hull."""
    if len(points) <= MOST_POINTS:
        return points
    return points[np.unique(np.argmax(points @ _EVERY_WAY.T, axis=0))]


@lru_cache(maxsize=64)
def _outline(fit: SuperquadricFit) -> NDArray[np.float64]:
    """Corners of a box, rims of a cylinder, else points all over the surface, (N, 3)."""
    solid = fit.superquadric
    assert solid is not None
    match solid.kind:
        case "box":
            return solid.to_parent(_CORNERS * solid.semi_axes)
        case "cylinder":
            return solid.to_parent(_RIMS * solid.semi_axes)
        case "sphere" | "ellipsoid":
            return solid.to_parent(_SPHERE * solid.semi_axes)
    directions = np.vstack([_SPHERE, _EDGES, _RIMS]) * solid.semi_axes
    return solid.project_radially(solid.to_parent(directions))


def gap_between(one: NDArray[np.float64], other: NDArray[np.float64]) -> Gap:
    """Find the widest slab between two hulls of points (N, 3) and (M, 3), m.

    Over fixed directions and that from centre to centre: no wider than the true one.
    """
    between = one.mean(axis=0) - other.mean(axis=0)
    length = float(np.linalg.norm(between))
    normals = np.vstack([_NORMALS, between / length]) if length > 0.0 else _NORMALS
    starts = (other @ normals.T).max(axis=0)
    widths = (one @ normals.T).min(axis=0) - starts
    best = int(np.argmax(widths))
    return Gap(normals[best], float(starts[best]), float(widths[best]))


def shadow(
    points: NDArray[np.float64],
    eye: NDArray[np.float64],
    support: SupportPlane | None,
    length: float,
    gap: Gap | None = None,
    room: float = 0.0,
) -> NDArray[np.float64]:
    """Corner points of an object and of what is behind it as seen from the camera.

    Parameters
    ----------
    points
        On the object (N, 3), m.
    eye
        Place of the camera (3,), m.
    support
        Rays end at it.
    length
        Or after so many m.
    gap
        To another thing that rays keep away from; wider than 0.
    room
        By so many m, or the width of the gap if that is less.

    Returns
    -------
    ndarray
        (2 N, 3), m: the points, then the ends of their rays.
    """
    rays = points - eye
    rays = rays / np.maximum(np.linalg.norm(rays, axis=1), 1e-9)[:, None]
    far = np.full(len(points), length)
    if support is not None:
        sinks = -(rays @ support.normal)
        height = np.maximum(support.height(points) - TABLE_SKIN, 0.0)
        far = np.minimum(far, _ratio(height, sinks))
    if gap is not None:
        nears = -(rays @ gap.normal)
        away = points @ gap.normal - gap.start - min(room, gap.width)
        far = np.minimum(far, _ratio(np.maximum(away, 0.0), nears))
    return np.vstack([points, points + far[:, None] * rays])


def _ratio(way: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far to go until a way is used up; inf where it is not."""
    return np.divide(way, speed, out=np.full(len(way), np.inf), where=speed > 1e-9)


def _evenly_on_sphere(count: int) -> NDArray[np.float64]:
    """Points spread over the unit sphere along a spiral of the golden angle, (count, 3)."""
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    z = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    around = np.sqrt(1.0 - z**2)
    return np.column_stack([around * np.cos(turn), around * np.sin(turn), z])


_SPHERE = _evenly_on_sphere(POINTS)
_EDGES = np.array([c for c in np.ndindex(3, 3, 3) if c != (1, 1, 1)], dtype=np.float64) - 1.0
_CORNERS = np.array(list(np.ndindex(2, 2, 2)), dtype=np.float64) * 2.0 - 1.0
_TURNS = np.arange(RIM_POINTS) * 2.0 * np.pi / RIM_POINTS
_RIM = np.column_stack([np.cos(_TURNS), np.sin(_TURNS), np.ones(RIM_POINTS)])
_RIMS = np.vstack([_RIM, _RIM * [1.0, 1.0, -1.0]])
_NORMALS = _evenly_on_sphere(DIRECTIONS)
_EVERY_WAY = _evenly_on_sphere(MOST_POINTS)

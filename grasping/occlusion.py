"""The space behind an object that the camera cannot see."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .sphere_points import evenly_on_sphere

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SceneObject, Superquadric, SuperquadricFit, SupportPlane

SPHERE_POINTS = 60
"""Number of points on a round solid, about 25° apart."""
RIM_POINTS = 16
"""Number of points on each rim of a cylinder."""
MAX_POINTS = 150
"""Maximum number of points of an object without a solid."""
SLAB_DIRECTIONS = 96
"""Number of directions in which a separating slab is searched."""
TABLE_GAP = 0.001
"""Height above the table at which the occluded space ends, m."""


class Slab(NamedTuple):
    """The space between two parallel planes that touch two objects."""

    normal: NDArray[np.float64]
    """Unit normal (3,), pointing away from the second object."""
    start: float
    """Coordinate along the normal at which the second object ends, m."""
    width: float
    """Thickness, m; negative if the objects overlap in every direction tried."""


def hull_points(item: SceneObject) -> NDArray[np.float64]:
    """Return points (N, 3), m, whose convex hull encloses an object.

    They come from the fitted solids, or from the segmented points if there are none.
    """
    if item.fit.superquadric is None or not item.fit:
        return extreme_points(item.points)
    return _fit_points(item.fit)


def extreme_points(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points (N, 3) that are extreme in some direction; their hull is nearly equal."""
    if len(points) <= MAX_POINTS:
        return points
    return points[np.unique(np.argmax(points @ _EXTREME_DIRECTIONS.T, axis=0))]


@lru_cache(maxsize=64)
def _fit_points(fit: SuperquadricFit) -> NDArray[np.float64]:
    solids = fit.parts or (fit.superquadric,)
    return np.concatenate([_solid_points(solid) for solid in solids if solid is not None])


def _solid_points(solid: Superquadric) -> NDArray[np.float64]:
    """Return corners of a box, rims of a cylinder, or points on any other surface, (N, 3), m."""
    match solid.kind:
        case "box":
            return solid.to_parent(_CORNERS * solid.semi_axes)
        case "cylinder":
            return solid.to_parent(_RIMS * solid.semi_axes)
        case "sphere" | "ellipsoid":
            return solid.to_parent(_SPHERE * solid.semi_axes)
    directions = np.vstack([_SPHERE, _EDGES, _RIMS]) * solid.semi_axes
    return solid.project_radially(solid.to_parent(directions))


def separating_slab(one: NDArray[np.float64], other: NDArray[np.float64]) -> Slab:
    """Find the widest slab between the hulls of points (N, 3) and (M, 3), m.

    The search uses fixed directions and the line between the centres. Therefore the slab is never
    wider than the true gap.
    """
    between = one.mean(axis=0) - other.mean(axis=0)
    length = float(np.linalg.norm(between))
    normals = np.vstack([_SLAB_NORMALS, between / length]) if length > 0.0 else _SLAB_NORMALS
    starts = (other @ normals.T).max(axis=0)
    widths = (one @ normals.T).min(axis=0) - starts
    best = int(np.argmax(widths))
    return Slab(normals[best], float(starts[best]), float(widths[best]))


def occluded_points(
    points: NDArray[np.float64],
    eye: NDArray[np.float64],
    support: SupportPlane | None,
    length: float,
    slab: Slab | None = None,
    free_width: float = 0.0,
) -> NDArray[np.float64]:
    """Return points whose hull encloses an object and the space occluded by it.

    Parameters
    ----------
    points
        Points on the object (N, 3), m.
    eye
        Position of the camera (3,), m.
    support
        Support plane, at which the occluded space ends.
    length
        Maximum length of the occluded space along a ray, m.
    slab
        Slab between the object and another one; its width must be positive.
    free_width
        Part of the slab that stays free, m; at most the slab's width.

    Returns
    -------
    ndarray
        (2 N, 3), m: the points, then the ends of their rays.
    """
    rays = points - eye
    rays = rays / np.maximum(np.linalg.norm(rays, axis=1), 1e-9)[:, None]
    lengths = np.full(len(points), length)
    if support is not None:
        descent = -(rays @ support.normal)
        height = np.maximum(support.height(points) - TABLE_GAP, 0.0)
        lengths = np.minimum(lengths, _ray_lengths(height, descent))
    if slab is not None:
        speed = -(rays @ slab.normal)
        distance = points @ slab.normal - slab.start - min(free_width, slab.width)
        lengths = np.minimum(lengths, _ray_lengths(np.maximum(distance, 0.0), speed))
    return np.vstack([points, points + lengths[:, None] * rays])


def _ray_lengths(distance: NDArray[np.float64], speed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ray lengths at which a distance is used up; inf if it never is."""
    return np.divide(distance, speed, out=np.full(len(distance), np.inf), where=speed > 1e-9)


_SPHERE = evenly_on_sphere(SPHERE_POINTS)
_EDGES = np.array([c for c in np.ndindex(3, 3, 3) if c != (1, 1, 1)], dtype=np.float64) - 1.0
_CORNERS = np.array(list(np.ndindex(2, 2, 2)), dtype=np.float64) * 2.0 - 1.0
_RIM_ANGLES = np.arange(RIM_POINTS) * 2.0 * np.pi / RIM_POINTS
_RIM = np.column_stack([np.cos(_RIM_ANGLES), np.sin(_RIM_ANGLES), np.ones(RIM_POINTS)])
_RIMS = np.vstack([_RIM, _RIM * [1.0, 1.0, -1.0]])
_SLAB_NORMALS = evenly_on_sphere(SLAB_DIRECTIONS)
_EXTREME_DIRECTIONS = evenly_on_sphere(MAX_POINTS)

"""The true surface of a touch object, against which measured points are compared."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from .column_entry import BOX, CAPSULE, CYLINDER, ELLIPSOID, NO_ENTRY, SPHERE, column_entry
from .touch_objects import Part, TouchObject

_KINDS = {
    "sphere": SPHERE,
    "capsule": CAPSULE,
    "ellipsoid": ELLIPSOID,
    "cylinder": CYLINDER,
    "box": BOX,
}
_HALVINGS = 80
_OFF_PLANE = 1e-12


def surface_distance(thing: TouchObject, points: ArrayLike) -> NDArray[np.float64]:
    """Compute the signed distance of points to an object's surface.

    Parameters
    ----------
    thing
        The object, undeformed.
    points
        (M, 3) in the object's frame, m.

    Returns
    -------
    NDArray
        (M,), m: exact outside. Inside it is negative: minus the depth in the part that holds the
        point deepest.
    """
    places = np.atleast_2d(np.asarray(points, float))
    return np.min([_part_distance(part, places) for part in thing.parts], axis=0)


def top_surface(thing: TouchObject, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
    """Compute the height of an object's surface, seen from above.

    Parameters
    ----------
    thing
        The object, undeformed.
    x, y
        (M,) in the object's frame, m.

    Returns
    -------
    NDArray
        (M,), z, m; NaN beside the object.
    """
    across = np.column_stack([np.asarray(x, float), np.asarray(y, float)])
    heights = np.full(len(across), np.nan)
    for part in thing.parts:
        turn = Rotation.from_quat(part.quat_wxyz, scalar_first=True)
        starts = np.column_stack([across, np.zeros(len(across))]) - part.place
        starts = turn.inv().apply(starts)
        direction = tuple(turn.inv().apply([0.0, 0.0, -1.0]))
        size = (*part.size, 0.0, 0.0)[:3]
        for k, start in enumerate(starts):
            entry = column_entry(_KINDS[part.kind], size, tuple(start), direction)
            if entry != NO_ENTRY:
                heights[k] = np.fmax(heights[k], -entry)
    return heights


def _part_distance(part: Part, points: NDArray[np.float64]) -> NDArray[np.float64]:
    turn = Rotation.from_quat(part.quat_wxyz, scalar_first=True)
    local = turn.inv().apply(points - part.place)
    if part.kind == "ellipsoid":
        return _ellipsoid_distance(np.array(part.size), local)
    if part.kind == "box":
        return _corner_distance(np.abs(local) - part.size)
    if part.kind == "cylinder":
        radial = np.hypot(local[:, 0], local[:, 1]) - part.size[0]
        return _corner_distance(np.column_stack([radial, np.abs(local[:, 2]) - part.size[1]]))
    half = part.size[1] if part.kind == "capsule" else 0.0
    local[:, 2] -= np.clip(local[:, 2], -half, half)
    return np.linalg.norm(local, axis=1) - part.size[0]


def _corner_distance(beyond: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the distance to a convex corner from the distances beyond its faces, (M, K)."""
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def _ellipsoid_distance(
    axes: NDArray[np.float64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Compute the distance by bisection (Eberly, Distance from a Point to an Ellipsoid, 2013).

    The nearest point is (a² p / (t + a²)) for the largest root t of sum (a p / (t + a²))² = 1. The
    search runs over t + c², c the smallest semi-axis, which keeps its digits when t is near -c².
    """
    # On a plane of symmetry the nearest point may lie off the plane; a small offset finds it.
    away = np.maximum(np.abs(points), _OFF_PLANE)
    squares = axes**2
    gaps = squares - squares.min()
    # At the lower bound a single term is at least 1; at the upper bound the sum is at most 1.
    low = (axes * away - gaps).max(axis=1)
    high = np.linalg.norm(axes * away, axis=1)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = ((axes * away / (middle[:, None] + gaps)) ** 2).sum(axis=1) > 1.0
        low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
    feet = squares * away / (high[:, None] + gaps)
    inside = ((away / axes) ** 2).sum(axis=1) < 1.0
    return np.where(inside, -1.0, 1.0) * np.linalg.norm(away - feet, axis=1)

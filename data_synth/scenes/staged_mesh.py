"""Closed triangle meshes of solids of revolution, bent tubes and tapered boxes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

TURN_SEGMENTS = 180
"""Facets around a solid of revolution: a radius of 80 mm is exact to 0.012 mm, a thirtieth of what
the best depth camera resolves there."""
TUBE_SEGMENTS = 48
"""Facets around a bent tube: a radius of 6 mm is exact to 0.013 mm."""


def turned_mesh(
    profile: Sequence[tuple[float, float]],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Create the mesh of a profile turned about the z-axis.

    Parameters
    ----------
    profile
        Two or more points (radius, z), m, from the axis along the outside and back to the axis:
        counter-clockwise if z points up and the radius to the right. A flat cap closes an end that
        is not on the axis.

    Returns
    -------
    vertices, faces
        (V, 3) float64 in m, (T, 3) int64, counter-clockwise seen from outside.
    """
    points = [(max(radius, 0.0), z) for radius, z in profile]
    if points[0][0] > 0:
        points.insert(0, (0.0, points[0][1]))
    if points[-1][0] > 0:
        points.append((0.0, points[-1][1]))
    rings = np.array(points[1:-1])
    angle = np.linspace(0.0, 2 * np.pi, TURN_SEGMENTS, endpoint=False)
    around = np.column_stack([np.cos(angle), np.sin(angle), np.ones_like(angle)])
    grid = np.stack([rings[:, 0], rings[:, 0], rings[:, 1]], axis=1)[:, None] * around
    return _capped(grid, (0.0, 0.0, points[0][1]), (0.0, 0.0, points[-1][1]))


def tapered_mesh(
    bottom: tuple[float, float], top: tuple[float, float], height: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Create the mesh of a frustum with rectangular ends, upright on z = 0 around the z-axis.

    Parameters
    ----------
    bottom, top
        Extents of the ends along x and y, m.
    height
        Distance between the ends, m.

    Returns
    -------
    vertices, faces
        (10, 3) float64 in m, (16, 3) int64, counter-clockwise seen from outside.
    """
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2
    ends = [(bottom, 0.0), (top, height)]
    grid = np.stack([np.column_stack([corners * size, [z] * 4]) for size, z in ends])
    return _capped(grid, (0.0, 0.0, 0.0), (0.0, 0.0, height))


def tube_mesh(path: ArrayLike, radius: float) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Create the mesh of a round tube along a path in the xz-plane, with flat ends.

    Parameters
    ----------
    path
        Points (x, z) of the tube's centre line, (P, 2), m.
    radius
        Radius of the tube, m.

    Returns
    -------
    vertices, faces
        (V, 3) float64 in m, (T, 3) int64, counter-clockwise seen from outside.
    """
    path = np.asarray(path, dtype=np.float64)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    middle = np.insert(path, 1, 0.0, axis=1)
    across = np.insert(along[:, ::-1] * [-1, 1], 1, 0.0, axis=1)
    angle = np.linspace(0.0, 2 * np.pi, TUBE_SEGMENTS, endpoint=False)
    sideways = np.sin(angle)[:, None] * [0.0, -1.0, 0.0]
    rim = np.cos(angle)[None, :, None] * across[:, None] + sideways[None]
    return _capped(middle[:, None] + radius * rim, middle[0], middle[-1])


def _capped(
    grid: NDArray[np.float64], first: ArrayLike, last: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Join rings (R, N, 3) to a closed mesh with two end points.

    The rings are counter-clockwise about the direction from the first to the last.
    """
    rings, around = grid.shape[:2]
    number = np.arange(rings * around).reshape(rings, around)
    after = np.roll(number, -1, axis=1)
    start, end = rings * around, rings * around + 1
    low, low_after, high, high_after = (
        a.ravel() for a in (number[:-1], after[:-1], number[1:], after[1:])
    )
    faces = [
        np.column_stack([low, low_after, high_after]),
        np.column_stack([low, high_after, high]),
        np.column_stack([np.full(around, start), after[0], number[0]]),
        np.column_stack([np.full(around, end), number[-1], after[-1]]),
    ]
    return np.vstack([grid.reshape(-1, 3), first, last]), np.vstack(faces).astype(np.int64)

"""Removal of points without neighbours: flying pixels, dust, points of other objects."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .neighbour_kernels import nearest_neighbours

NEIGHBOURS = 6
"""Neighbours whose mean distance decides whether a point is an outlier."""
OUTLIER_RATIO = 2.5
"""Maximum mean distance of a point to its neighbours, divided by the median of all points. Beyond
it the point is an outlier."""
PITCH_QUANTILE = 0.1
"""The pitch is this quantile of the nearest-neighbour distances. Noise moves some points together,
so the minimum is too small."""
GRID_RATIO = 0.6
"""Minimum ratio of pitch to median distance for points of an image; random points have 0.39."""
DEPTH_WEIGHT = 0.4
"""Weight of depth in these distances. On a surface seen at a grazing angle, points lie far apart
in depth, and these points determine the width of the object."""


class FilteredCloud(NamedTuple):
    """A cloud without outliers."""

    points: NDArray[np.float64]
    """(M, 3), m."""
    pitch: float
    """Typical minimum distance of neighbours, m: the size of a pixel on the object."""
    on_grid: bool
    """Whether the points lie on the pixel grid of an image, and not at random places."""


def remove_outliers(
    points: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> FilteredCloud:
    """Return the points of a cloud (N, 3) whose neighbours are about as near as usual."""
    distances = _neighbour_distances(points, view_origin)
    if np.median(distances) == 0.0:
        points = np.unique(points, axis=0)
        distances = _neighbour_distances(points, view_origin)
    spacing = distances.mean(axis=1)
    keep = spacing <= OUTLIER_RATIO * np.median(spacing)
    pitch, median = np.quantile(distances[keep, 0], [PITCH_QUANTILE, 0.5])
    return FilteredCloud(points[keep], float(pitch), bool(pitch > GRID_RATIO * median))


def _neighbour_distances(
    points: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Return the distances (N, K) of the nearest neighbours, nearest first, depth weighted less."""
    count = min(NEIGHBOURS, len(points) - 1)
    if count < 1:
        return np.zeros((len(points), 1))
    if view_origin is not None:
        forward = points.mean(axis=0) - view_origin
        distance = float(np.linalg.norm(forward))
        if distance > 0.0:
            forward = forward / distance
            points = points - (1.0 - DEPTH_WEIGHT) * np.outer(points @ forward, forward)
    return nearest_neighbours(points, points, count + 1)[0][:, 1:]

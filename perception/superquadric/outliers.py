"""Leave out points that have no neighbours: flying pixels, dust, somebody else's points."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.spatial import KDTree

if TYPE_CHECKING:
    from numpy.typing import NDArray

NEIGHBOURS = 6
"""Neighbours whose mean distance tells an outlier."""
RATIO = 2.5
"""A point whose neighbours lie this many times farther than the median's is an outlier."""
PITCH_QUANTILE = 0.1
"""Share of points whose nearest neighbour is nearer than the pitch: noise moves some together."""
GRID_RATIO = 0.6
"""Least ratio of that pitch to the median distance in an image; at random it is 0.39."""
DEPTH_SHARE = 0.4
"""Weight of depth in that distance: a surface that a view grazes has its points far apart along
the rays, and they are what tells the object's width."""


class Neighbourly(NamedTuple):
    """Points that have neighbours."""

    cloud: NDArray[np.float64]
    """(M, 3), m."""
    pitch: float
    """Distance that nearest neighbours keep at least, m: an image's pixel."""
    on_grid: bool
    """Whether they do keep it, as pixels do, and points drawn at random do not."""


def without_outliers(
    cloud: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> Neighbourly:
    """Keep points of a cloud (N, 3) whose neighbours are about as near as everybody's."""
    distances = _neighbour_distances(cloud, view_origin)
    if np.median(distances) == 0.0:
        cloud = np.unique(cloud, axis=0)
        distances = _neighbour_distances(cloud, view_origin)
    spacing = distances.mean(axis=1)
    keep = spacing <= RATIO * np.median(spacing)
    nearest = distances[keep, 0]
    pitch, usual = np.quantile(nearest, [PITCH_QUANTILE, 0.5])
    return Neighbourly(cloud[keep], float(pitch), bool(pitch > GRID_RATIO * usual))


def _neighbour_distances(
    cloud: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Distances (N, K) of the nearest neighbours, nearest first, depth counting less."""
    count = min(NEIGHBOURS, len(cloud) - 1)
    if count < 1:
        return np.zeros((len(cloud), 1))
    if view_origin is not None:
        forward = cloud.mean(axis=0) - view_origin
        distance = float(np.linalg.norm(forward))
        if distance > 0.0:
            forward = forward / distance
            cloud = cloud - (1.0 - DEPTH_SHARE) * np.outer(cloud @ forward, forward)
    spacing, _ = KDTree(cloud).query(cloud, k=count + 1)
    return spacing[:, 1:]

"""Leave out points that have no neighbours: flying pixels, dust, somebody else's points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

if TYPE_CHECKING:
    from numpy.typing import NDArray

NEIGHBOURS = 6
"""Neighbours whose mean distance tells an outlier."""
RATIO = 2.5
"""A point whose neighbours lie this many times farther than the median's is an outlier."""
DEPTH_SHARE = 0.4
"""Weight of depth in that distance: a surface that a view grazes has its points far apart along
the rays, and they are what tells the object's width."""


def without_outliers(
    cloud: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Points (M, 3) of a cloud (N, 3) whose neighbours are about as near as everybody's."""
    spacing = _neighbour_distance(cloud, view_origin)
    if np.median(spacing) == 0.0:
        cloud = np.unique(cloud, axis=0)
        spacing = _neighbour_distance(cloud, view_origin)
    return cloud[spacing <= RATIO * np.median(spacing)]


def _neighbour_distance(
    cloud: NDArray[np.float64], view_origin: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    count = min(NEIGHBOURS, len(cloud) - 1)
    if count < 1:
        return np.zeros(len(cloud))
    if view_origin is not None:
        forward = cloud.mean(axis=0) - view_origin
        distance = float(np.linalg.norm(forward))
        if distance > 0.0:
            forward = forward / distance
            cloud = cloud - (1.0 - DEPTH_SHARE) * np.outer(cloud @ forward, forward)
    spacing, _ = KDTree(cloud).query(cloud, k=count + 1)
    return spacing[:, 1:].mean(axis=1)

"""Distance of points from the sides of a convex hull in plan."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def depth_in_hull(points, hull):
    """Return the distances (N,) of points (N, 2) from the sides of a convex hull, > 0 inside."""
    count = len(hull)
    area = 0.0
    for k in range(count):
        ax, ay = np.float64(hull[k, 0]), np.float64(hull[k, 1])
        bx, by = np.float64(hull[(k + 1) % count, 0]), np.float64(hull[(k + 1) % count, 1])
        area += ax * by - ay * bx
    turn = 1.0 if area >= 0 else -1.0
    depths = np.full(len(points), np.inf)
    for k in range(count):
        ax, ay = np.float64(hull[k, 0]), np.float64(hull[k, 1])
        sx, sy = hull[(k + 1) % count, 0] - ax, hull[(k + 1) % count, 1] - ay
        scale = turn / max(np.sqrt(sx * sx + sy * sy), 1e-9)
        for i in range(len(points)):
            depth = ((points[i, 1] - ay) * sx - (points[i, 0] - ax) * sy) * scale
            depths[i] = min(depths[i], depth)
    return depths

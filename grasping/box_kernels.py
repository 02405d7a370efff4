"""Compiled distance of points from the boxes around a hand."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def nearest_point(points, palm, axes, boxes):
    """Return the signed distance of the nearest point from a set of boxes, m, and its index.

    If points lie inside, the result is minus the greatest depth by which a point must be pushed: to
    the outside along the closing direction, or along the row of fingers. A box on both sides of the
    palm is left by its nearer side.

    Parameters
    ----------
    points
        Points, (M, 3), m, at least one.
    palm
        Position of the palm, (3,), m.
    axes
        Unit directions of closing, row of fingers and palm, (3, 3).
    boxes
        Low and high corners along these axes, (B, 2, 3), m, with the palm as origin.
    """
    least, nearest = np.inf, 0
    deepest, inner = 0.0, 0
    local, bounds = np.empty(3), np.empty((2, 3))
    for axis in range(3):
        bounds[0, axis], bounds[1, axis] = boxes[:, 0, axis].min(), boxes[:, 1, axis].max()
    for k in range(len(points)):
        for axis in range(3):
            local[axis] = 0.0
            for j in range(3):
                local[axis] += axes[axis, j] * (points[k, j] - palm[j])
        outside = 0.0
        for axis in range(3):
            gap = max(bounds[0, axis] - local[axis], local[axis] - bounds[1, axis])
            outside += max(gap, 0.0) ** 2
        # Most points are farther from all boxes than the nearest one so far.
        if outside > 0.0 and outside >= least:
            continue
        for b in range(len(boxes)):
            squared, inside = 0.0, True
            for axis in range(3):
                low, high = boxes[b, 0, axis] - local[axis], local[axis] - boxes[b, 1, axis]
                gap = max(low, high)
                squared += max(gap, 0.0) ** 2
                inside = inside and gap < 0.0
            if squared < least:
                least, nearest = squared, k
            if inside:
                depth = _push_depth(local, boxes[b])
                if depth > deepest:
                    deepest, inner = depth, k
    if least > 0.0:
        return np.sqrt(least), nearest
    return -deepest, (inner if deepest > 0.0 else nearest)


@njit(cache=True)
def _push_depth(local, box):
    """Return the way of a point out of a box: along the closing direction or the row, m."""
    out_low, out_high = local[0] - box[0, 0], box[1, 0] - local[0]
    across = min(out_low, out_high)
    # A finger can only push a neighbour away from the grasped object.
    if box[1, 0] <= 0.0:
        across = out_low
    if box[0, 0] >= 0.0:
        across = out_high
    return min(across, min(local[1] - box[0, 1], box[1, 1] - local[1]))

"""Compiled search for the highest points around a middle, and the circle through them."""

from __future__ import annotations

import numpy as np
from numba import njit

SECTORS = 24
"""Sectors about the middle of the rim in which the highest points are searched."""
SECTOR_RANK = 2
"""The top of a sector is its second highest point. The highest one has the most noise."""
RIM_NOISE = 1.0
"""The rim in a sector is the outermost point less than this below its top, in expected noise. A
thick wall has a wide rim, whose highest point may lie anywhere on it."""
TRIMS = 2
TRIM_RATIO = 3.0
"""Points of the rim farther away than so many times the median do not count."""
MIN_SPREAD = 1e-9
"""Ratio of the determinant of the points' scatter to the square of its trace below which they lie
on a line."""


@njit(cache=True)
def rim_points(local, middle, noise):  # pragma: no cover - compiled
    """Return the outermost of the highest points in each sector about a middle.

    Parameters
    ----------
    local
        (N, 3) points with the opening direction as z, m.
    middle
        (2,) middle of the sectors, m.
    noise
        Expected noise of the points, m.

    Returns
    -------
    (S, 3) points by sector; sectors with fewer than SECTOR_RANK points have none.
    """
    # The angle π makes a sector of its own.
    first = np.full(SECTORS + 1, -np.inf)
    second = np.full(SECTORS + 1, -np.inf)
    count = np.zeros(SECTORS + 1, np.int64)
    sectors = np.empty(len(local), np.int64)
    for i in range(len(local)):
        angle = np.arctan2(local[i, 1] - middle[1], local[i, 0] - middle[0])
        sector = int(np.floor((angle / (2 * np.pi) + 0.5) * SECTORS))
        sectors[i] = sector
        count[sector] += 1
        z = local[i, 2]
        if z > first[sector]:
            second[sector] = first[sector]
            first[sector] = z
        elif z > second[sector]:
            second[sector] = z
    outermost = np.full(SECTORS + 1, -1)
    largest = np.full(SECTORS + 1, -1.0)
    for i in range(len(local)):
        sector = sectors[i]
        if count[sector] < SECTOR_RANK or local[i, 2] < second[sector] - RIM_NOISE * noise:
            continue
        radius = np.hypot(local[i, 0] - middle[0], local[i, 1] - middle[1])
        if radius > largest[sector]:
            largest[sector] = radius
            outermost[sector] = i
    return local[outermost[outermost >= 0]]


@njit(cache=True)
def circle_through(points):  # pragma: no cover - compiled
    """Return the circle and the plane through points (S, 3) with the least squares.

    Returns
    -------
    (6,) middle and radius of the circle, slopes and offset of the plane z = a x + b y + c; NaN if
    the points lie on a line.
    """
    n = len(points)
    mean = np.zeros(3)
    for i in range(n):
        mean += points[i]
    mean /= n
    xx = xy = yy = xr = yr = xz = yz = rr = 0.0
    for i in range(n):
        x, y, z = points[i, 0] - mean[0], points[i, 1] - mean[1], points[i, 2] - mean[2]
        square = x * x + y * y
        xx += x * x
        xy += x * y
        yy += y * y
        xr += x * square
        yr += y * square
        xz += x * z
        yz += y * z
        rr += square
    determinant = xx * yy - xy * xy
    if determinant <= MIN_SPREAD * (xx + yy) ** 2:
        return np.full(6, np.nan)
    # The coordinates are centred, so that the constant is the mean of the targets.
    x = 0.5 * (yy * xr - xy * yr) / determinant
    y = 0.5 * (xx * yr - xy * xr) / determinant
    a = (yy * xz - xy * yz) / determinant
    b = (xx * yz - xy * xz) / determinant
    radius = np.sqrt(rr / n + x * x + y * y)
    offset = mean[2] - a * mean[0] - b * mean[1]
    return np.array([x + mean[0], y + mean[1], radius, a, b, offset])


@njit(cache=True)
def trimmed_circle(points, noise):  # pragma: no cover - compiled
    """Return circle and plane of points (S, 3) without those far from them.

    Returns
    -------
    circle, kept
        (6,) as of `circle_through`, and (S,) whether a point counts.
    """
    circle = circle_through(points)
    kept = np.ones(len(points), np.bool_)
    for _ in range(TRIMS):
        if np.isnan(circle[0]):
            break
        x, y = points[:, 0], points[:, 1]
        radial = np.hypot(x - circle[0], y - circle[1]) - circle[2]
        height = points[:, 2] - x * circle[3] - y * circle[4] - circle[5]
        error = np.hypot(radial, height)
        kept = error <= TRIM_RATIO * np.median(error) + noise
        circle = circle_through(points[kept])
    return circle, kept

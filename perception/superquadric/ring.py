"""A ring of the highest points of a cloud: the possible rim of a vessel."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

MIN_SECTORS = 0.75
"""Minimum share of the sectors that show the rim."""
MAX_RIM_SPREAD = 0.06
"""Maximum deviation of the rim from its ellipse over its mean radius, standard deviation. The
nearer rim shows the outer edge, the farther one the inner edge. A square deviates by 0.1."""
MAX_RIM_HEIGHT = 0.05
"""Maximum deviation of the rim from its plane over its diameter, standard deviation."""
MAX_ASPECT = 2.0
"""Maximum ratio of the semi-axes of a rim."""
ELLIPSE_GAIN = 2.0
"""Ratio of the mean squares about circle and ellipse from which on the rim is an ellipse. It pays
for two parameters of 24 sectors under strong evidence."""


class Ring(NamedTuple):
    """Highest points around a middle, in coordinates with the opening direction as z."""

    points: NDArray[np.float64]
    """(S, 3) highest points of the sectors that show the rim, m."""
    middle: NDArray[np.float64]
    """(2,) middle of the ellipse, m."""
    semi_axes: NDArray[np.float64]
    """(2,) m."""
    angle: float
    """Angle of the first semi-axis, rad."""
    plane: NDArray[np.float64]
    """(3,) slopes and offset of the plane z = a x + b y + c."""

    def scale(self, flat: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the scale (N,) of the ellipse about its middle that touches points (N, 2)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.linalg.norm(
            (flat - self.middle) @ np.array([[c, -s], [s, c]]) / self.semi_axes, axis=1
        )

    def radial_error(self) -> NDArray[np.float64]:
        """Return the distances (S,) of the points from the ellipse along their rays, m."""
        flat = self.points[:, :2]
        radius = np.linalg.norm(flat - self.middle, axis=1)
        return radius * (1.0 - 1.0 / np.maximum(self.scale(flat), 1e-9))

    def is_level_ellipse(self, noise: float) -> bool:
        """Return whether the points form a level ellipse, with an expected noise in m."""
        radius = float(np.mean(self.semi_axes))
        spread = float(np.sqrt(np.mean(self.radial_error() ** 2)))
        level = float(np.std(self.points[:, 2]))
        return (
            self.semi_axes[0] <= MAX_ASPECT * self.semi_axes[1]
            and spread <= MAX_RIM_SPREAD * radius + noise
            and level <= MAX_RIM_HEIGHT * radius + noise
        )


def find_ring(local: NDArray[np.float64], middle: NDArray[np.float64], noise: float) -> Ring | None:
    """Return the highest points (N, 3) of the sectors about a middle (2,), and their circle.

    A sector may miss the rim, because the search for outliers drops thin strips. Points far from
    the plane or the circle of the others do not count. Returns None if too few sectors remain.
    """
    highest = rim_points(local, middle, noise)
    if len(highest) < MIN_SECTORS * SECTORS:
        return None
    circle, kept = trimmed_circle(highest, noise)
    if np.isnan(circle[0]) or np.count_nonzero(kept) < MIN_SECTORS * SECTORS:
        return None
    return Ring(highest[kept], circle[:2], np.full(2, circle[2]), 0.0, circle[3:])


def with_ellipse(circle: Ring) -> Ring:
    """Return a ring with an ellipse if that is clearly closer than its circle."""
    flat = circle.points[:, :2]
    (x, y), (first, second), degrees = cv2.fitEllipseDirect((1e3 * flat).astype(np.float32))
    semi_axes, angle = 0.5e-3 * np.array([first, second]), float(np.radians(degrees))
    if second > first:
        semi_axes, angle = semi_axes[::-1], angle + np.pi / 2
    if not (np.all(np.isfinite(semi_axes)) and semi_axes[1] > 0):
        return circle
    ellipse = circle._replace(middle=1e-3 * np.array([x, y]), semi_axes=semi_axes, angle=angle)
    gain = np.mean(circle.radial_error() ** 2) / max(np.mean(ellipse.radial_error() ** 2), 1e-12)
    return ellipse if gain > ELLIPSE_GAIN else circle


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

"""A ring of the highest points of a cloud: the possible rim of a vessel."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .ring_kernels import SECTORS, rim_points, trimmed_circle

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

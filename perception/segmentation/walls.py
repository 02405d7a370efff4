"""Walls and other surroundings: large upright faces at the edge of a support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .median import median

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_extent import Support

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""
MIN_LENGTH = 0.2
"""Minimum horizontal length of a wall, m. A hand cannot lift a box of this length by its front."""
MIN_HEIGHT = 0.35
"""Minimum height of a narrower one, m: the front edges of the sides of a shelf."""
MAX_LEAN = 0.3
"""Maximum angle between a wall and the vertical, rad. The walls of totes lean by up to 0.2."""
MAX_RESIDUAL = 0.004
"""Maximum scatter of a wall's readings about its plane, m: a box shows a second face."""
RESIDUAL_SIGMAS = 3.0
"""The same in σ of the support's own readings. The larger one holds."""
MIN_POINTS = 10
"""Minimum number of readings that show a plane."""
MAX_BEHIND = 0.03
"""Maximum distance at which the support is visible behind a wall, m."""


def is_wall(points: NDArray[np.float64], support: Support) -> bool:
    """Return whether a region is a flat upright face at the edge of a support.

    Shelves and boxes have such walls, and tables have screens and walls behind them. A box on the
    support shows its top or a second face, or the support is visible behind it.

    Parameters
    ----------
    points
        Readings of the region (N, 3), m, camera frame.
    support
        The support on which the region stands.
    """
    if len(points) < MIN_POINTS:
        return False
    # The bounding box bounds the length. Most objects are smaller, and the fit takes long.
    rise = np.ptp(points @ support.plane.normal)
    if np.hypot(*np.ptp(points @ support.axes.T, axis=0)) < MIN_LENGTH and rise < MIN_HEIGHT:
        return False
    centre = points.mean(axis=0)
    _, _, directions = np.linalg.svd(points - centre, full_matrices=False)
    normal = directions[2]
    scatter = MAD_TO_SIGMA * median(np.abs((points - centre) @ normal))
    if scatter > max(MAX_RESIDUAL, RESIDUAL_SIGMAS * support.plane.tolerance):
        return False
    if abs(float(normal @ support.plane.normal)) > np.sin(MAX_LEAN):
        return False
    along = np.cross(normal, support.plane.normal)
    length = np.ptp(points @ (along / np.linalg.norm(along)))
    if length < MIN_LENGTH and rise < MIN_HEIGHT:
        return False
    across = support.axes @ normal
    beyond = (support.hull @ across - support.axes @ centre @ across) / np.linalg.norm(across)
    return bool(min(beyond.max(), -beyond.min()) <= MAX_BEHIND)

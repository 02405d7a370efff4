"""Walls and other surroundings: large upright faces at the edge of a support."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .hull_depth import depth_in_hull
from .median import median
from .point_extent import box_diagonal, trimmed_range
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
MAX_THICKNESS = 0.03
"""Maximum extent of a wall across its plane, m, if it stands outside the support: the front edge of
a side and its inner face."""
MAX_OUTSIDE = 0.005
"""Maximum distance of the middle reading of an object outside the hull, m."""
MAX_GRAZING = 0.5
"""Maximum cosine between the normal of a wall and the viewing ray at which the wall may begin
inside the hull. The image shows objects in the last row from the front."""
MAX_BESIDE = 0.05
"""Maximum distance of such a wall outside the hull, m."""
MIN_SIDE = 0.15
"""Minimum height of such a wall, m."""
MAX_BOARD = 0.03
"""Maximum height of a board's front edge and top, m."""
MIN_BOARD_LENGTH = 0.3
"""Minimum length of a board, m."""
MIN_BOARD_SHARE = 0.7
"""Minimum length of a board, as a share of the support's extent in its direction."""
MIN_BOARD_HEIGHT = 0.1
"""Minimum height of a board above a support, m."""
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
    if np.sqrt(2.0) * box_diagonal(points) < MIN_LENGTH:
        return False
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


def is_side(points: NDArray[np.float64], supports: list[Support]) -> bool:
    """Return whether a region is the side of a board: thin, upright, and outside of its hull.

    Parameters
    ----------
    points
        Readings of the region (N, 3), m, camera frame.
    supports
        The supports, at least one.
    """
    up = supports[0].plane.normal
    if len(points) < MIN_POINTS or box_diagonal(points) < MIN_SIDE:
        return False
    if np.ptp(points @ up) < MIN_SIDE:
        return False
    depths = [float(median(depth_in_hull(points @ one.axes.T, one.hull))) for one in supports]
    if not any(-MAX_BESIDE < depth < MAX_OUTSIDE for depth in depths):
        return False
    centred = points - points.mean(axis=0)
    normal = np.linalg.eigh(centred.T @ centred)[1][:, 0]
    if abs(float(normal @ up)) > np.sin(MAX_LEAN):
        return False
    across = np.sort(centred @ normal)
    last = len(across) - 1
    if across[round(0.95 * last)] - across[round(0.05 * last)] > MAX_THICKNESS:
        return False
    view = np.median(points, axis=0)
    grazing = abs(float(normal @ view)) < MAX_GRAZING * float(np.linalg.norm(view))
    least = MAX_OUTSIDE if grazing else -MAX_OUTSIDE
    return any(-MAX_BESIDE < depth < least for depth in depths)


def is_board(points: NDArray[np.float64], support: Support) -> bool:
    """Return whether a region is a board above a support, seen at its front edge.

    Parameters
    ----------
    points
        Readings of the region (N, 3), m, camera frame.
    support
        A support below it.
    """
    if box_diagonal(points) < MIN_BOARD_LENGTH:
        return False
    low, high = trimmed_range(support.plane.height(points), 0.02)
    if low < MIN_BOARD_HEIGHT or high - low > MAX_BOARD:
        return False
    plan = points @ support.axes.T
    along = np.linalg.svd(plan - plan.mean(axis=0), full_matrices=False)[2][0]
    length = float(np.ptp(plan @ along))
    return length >= max(MIN_BOARD_LENGTH, MIN_BOARD_SHARE * float(np.ptp(support.hull @ along)))

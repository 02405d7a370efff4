"""Supports on boards of which the image shows hardly more than the front edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .point_extent import trimmed_range
from .result import SupportPlane
from .support_extent import Support
from .walls import MAX_BOARD, MIN_BOARD_HEIGHT, is_board

DEPTH = 0.35
"""Assumed depth of a board behind its front edge, m."""
OUTLIERS = 0.02
"""Share of the readings of an edge beyond each of its ends."""
FRONT = 0.02
"""Distance before the edge up to which the foot of an object may stand, m."""

MIN_STRIP = 0.1
"""Minimum length of a piece of a board, m. Shorter ones may be objects on a hidden board."""
MAX_STEP = 0.01
"""Maximum difference in height between pieces of one board, m."""


def edge_board(points: NDArray[np.float64], supports: list[Support]) -> Support:
    """Return the support behind the front edge of a board.

    A camera at the height of a board sees its edge and the objects on it, but not its top. The
    support is a horizontal rectangle behind the edge, at the height of its upper end.

    Parameters
    ----------
    points
        Readings of the edge (N, 3), m, camera frame.
    supports
        The supports, at least one. The normal and the axes of the first one count.
    """
    first = supports[0]
    heights = np.sort(first.plane.height(points))
    top = float(heights[round((1 - OUTLIERS) * (len(heights) - 1))])
    plan = points @ first.axes.T
    middle = plan.mean(axis=0)
    along = np.linalg.svd(plan - middle, full_matrices=False)[2][0]
    behind = np.array([-along[1], along[0]])
    # The camera is at the origin of the plan.
    behind *= np.sign(behind @ middle) or 1.0
    s, d = (plan - middle) @ along, (plan - middle) @ behind
    low, high = np.quantile(s, [OUTLIERS, 1 - OUTLIERS])
    front = float(np.quantile(d, OUTLIERS)) - FRONT
    corners = [(low, front), (high, front), (high, front + DEPTH), (low, front + DEPTH)]
    hull = np.array([middle + x * along + y * behind for x, y in corners], np.float32)
    plane = SupportPlane(first.plane.normal, first.plane.offset - top, first.plane.tolerance)
    depth = float(np.median(points[:, 2]))
    return Support(plane, hull, first.axes, depth, score=0.0)


def divided_boards(
    regions: list[NDArray[np.float64]], supports: list[Support]
) -> list[NDArray[np.float64]]:
    """Return the heights (2,) of boards whose front edge several regions show together.

    Noise and objects divide a board that is seen at a grazing angle into pieces. Pieces are low and
    long, lie at one height, and not right above a known support.

    Parameters
    ----------
    regions
        Readings of each region (N, 3), m, camera frame.
    supports
        The supports. Heights are along the normal of the first one, from the camera, m.
    """
    strips = [points for points in regions if supports and _is_strip(points, supports)]
    found: list[NDArray[np.float64]] = []
    while len(strips) > 1:
        heights = [float(np.median(points @ supports[0].plane.normal)) for points in strips]
        near = [abs(height - heights[0]) <= MAX_STEP for height in heights]
        board = np.concatenate([strip for strip, one in zip(strips, near, strict=True) if one])
        if sum(near) > 1 and any(is_board(board, support) for support in supports):
            ends = [OUTLIERS, 1 - OUTLIERS]
            found.append(np.quantile(board @ supports[0].plane.normal, ends))
        strips = [strip for strip, one in zip(strips, near, strict=True) if not one]
    return found


def _is_strip(points: NDArray[np.float64], supports: list[Support]) -> bool:
    """Return whether a region is low, long, and not right above a support."""
    first = supports[0]
    if not len(points):
        return False
    low, high = trimmed_range(first.plane.height(points), OUTLIERS)
    if high - low > MAX_BOARD:
        return False
    above = [low + one.plane.offset - first.plane.offset for one in supports]
    if not all(height >= MIN_BOARD_HEIGHT or height < -MAX_STEP for height in above):
        return False
    return bool(np.linalg.norm(np.ptp(points @ first.axes.T, axis=0)) >= MIN_STRIP)

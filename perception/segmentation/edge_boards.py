"""Supports on boards of which the image shows hardly more than the front edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .result import SupportPlane
from .support_extent import Support

DEPTH = 0.35
"""Assumed depth of a board behind its front edge, m."""
OUTLIERS = 0.02
"""Share of the readings of an edge beyond each of its ends."""
FRONT = 0.02
"""Distance before the edge up to which the foot of an object may stand, m."""


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

"""Share of a plane's front edge below which the scene is open: boards and tables, not boxes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .result import SupportPlane
    from .working_image import WorkingImage

DEPTHS_BELOW = (0.05, 0.08)
"""Heights below the plane at which the image is probed, m. Boards and table tops are thinner."""
SPACING = 0.01
"""Distance between the probes along the outline, m."""
MIN_FACING = 0.3
"""Minimum cosine between the outline's normal and the direction to the camera in plan."""
MIN_CLEARANCE = 0.04
"""Minimum distance behind the edge of a reading that shows an open space, m."""
MIN_PROBED = 8
"""Minimum number of probes that decide."""


def open_share(
    plane: SupportPlane,
    hull: NDArray[np.float32],
    axes: NDArray[np.float64],
    image: WorkingImage,
) -> float:
    """Return the share of the front edge of a plane below which the image shows no face, 0 to 1.

    The front face of a box lies straight below the edge of its top. Below the edge of a board the
    readings lie farther behind. The share is 0 if too few places of the edge are visible.

    Parameters
    ----------
    plane
        The plane in the camera frame.
    hull
        Convex hull of its readings in plan, (K, 2), m.
    axes
        Axes of the plan as rows, (2, 3).
    image
        The whole image.
    """
    opened, closed = probe_edge(
        hull.astype(np.float64),
        np.vstack([plane.normal, axes]),
        plane.offset,
        image.depth,
        image.pinhole,
    )
    return opened / (opened + closed) if opened + closed >= MIN_PROBED else 0.0


@njit(cache=True, nogil=True)
def probe_edge(hull, axes, offset, depth, pinhole):
    """Return the numbers of probes below the front edge that show an open space, and a face.

    Parameters
    ----------
    hull
        Convex hull in plan, (K, 2), m.
    axes
        Rows (3, 3): the normal of the plane, and the two axes of the plan.
    offset
        Offset of the plane, m.
    depth
        (H, W) float32, m.
    pinhole
        fx, fy, cx, cy.
    """
    fx, fy, cx, cy = pinhole
    rows, columns = depth.shape
    middle_x, middle_y = hull[:, 0].mean(), hull[:, 1].mean()
    opened = closed = 0
    for k in range(len(hull)):
        start_x, start_y = hull[k]
        dx, dy = hull[(k + 1) % len(hull)] - hull[k]
        length = np.sqrt(dx * dx + dy * dy)
        out_x, out_y = dy / max(length, 1e-9), -dx / max(length, 1e-9)
        if out_x * (start_x - middle_x) + out_y * (start_y - middle_y) < 0:
            out_x, out_y = -out_x, -out_y
        count = max(int(length / SPACING), 1)
        for m in range(count):
            share = (m + 0.5) / count
            x, y = start_x + share * dx, start_y + share * dy
            # The camera is at the origin of the plan.
            if -(x * out_x + y * out_y) <= MIN_FACING * np.sqrt(x * x + y * y):
                continue
            for below in DEPTHS_BELOW:
                height = -(offset + below)
                px = x * axes[1, 0] + y * axes[2, 0] + height * axes[0, 0]
                py = x * axes[1, 1] + y * axes[2, 1] + height * axes[0, 1]
                z = x * axes[1, 2] + y * axes[2, 2] + height * axes[0, 2]
                if z <= 0:
                    continue
                u, v = int(np.rint(px / z * fx + cx)), int(np.rint(py / z * fy + cy))
                if u < 0 or v < 0 or u >= columns or v >= rows or depth[v, u] <= 0:
                    continue
                behind = depth[v, u] - z
                opened += behind > MIN_CLEARANCE
                closed += abs(behind) <= MIN_CLEARANCE
    return opened, closed

"""Check whether walls rise around a floor, as in a bin whose rims the image does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_extent import Support
    from .working_image import WorkingImage

MIN_RISING_SHARE = 0.85
"""Minimum share of the floor's outline beside which a wall rises. The outlines of tables have at
most 0.8, where many things stand at the edge; those of bins have 1."""
MIN_RISE = 0.005
"""Minimum height of a wall within the probed distance, m."""
PROBES = (0.01, 0.02, 0.03)
"""Distances outside the outline at which the image is probed, m."""
MAX_OFFSET = 0.06
"""Maximum distance in plan between a probe and the reading in its pixel, m. A reading farther away
belongs to something behind."""
SPACING = 0.01
"""Distance between the probes along the outline, m."""
MIN_PROBED = 20
"""Minimum number of probes with a reading. An outline that leaves the image has fewer."""
MIN_FACING = 0.3
"""Minimum cosine between the outline's normal and the direction to the camera, in plan, of the
front edge."""
MIN_FRONT = 0.5
"""Minimum share of the front edge that the image contains. Boards have walls on the other three
sides."""


def is_enclosed(support: Support, image: WorkingImage) -> bool:
    """Return whether a wall rises beside nearly the whole outline of a support.

    The outline is probed at places beside it. A wall rises there if the reading in the pixel of a
    probe is above the support and near the probe in plan.
    """
    hull = support.hull.astype(np.float64)
    normals, counts = _sides(hull)
    # The camera is at the origin of the plan.
    axes = np.vstack([support.plane.normal, support.axes])
    front, visible, probed, rising = probe_walls(
        hull, normals, counts, axes, support.plane.offset, image.depth, image.pinhole
    )
    if visible < MIN_FRONT * front:
        return False
    return probed >= MIN_PROBED and rising >= MIN_RISING_SHARE * probed


def _sides(hull: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return the outward unit normals (K, 2) of a hull's sides, and their numbers of places."""
    edges = np.roll(hull, -1, axis=0) - hull
    lengths = np.linalg.norm(edges, axis=1)
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.maximum(lengths, 1e-9)[:, None]
    inwards = np.einsum("ij,ij->i", normals, hull - hull.mean(axis=0)) < 0
    normals[inwards] *= -1.0
    return normals, np.maximum((lengths / SPACING).astype(np.intp), 1)


@njit(cache=True, nogil=True)
def probe_walls(hull, normals, counts, axes, offset, depth, pinhole):
    """Count the places along an outline at which a wall may rise.

    Parameters
    ----------
    hull
        Convex hull of a plane in plan, (K, 2), m.
    normals, counts
        Outward unit normals of its sides (K, 2), and the numbers of places along them (K,).
    axes
        Rows (3, 3): the normal of the plane, and the two axes of the plan.
    offset
        Offset of the plane, m.
    depth
        (H, W) float32, m.
    pinhole
        fx, fy, cx, cy.

    Returns
    -------
    front, visible, probed, rising
        The places of the front edge, and those of them in the image; the places with a reading,
        and those at which a reading near the place is above the plane.
    """
    fx, fy, cx, cy = pinhole
    rows, columns = depth.shape
    front = visible = probed = rising = 0
    for k in range(len(hull)):
        start_x, start_y = hull[k]
        dx, dy = hull[(k + 1) % len(hull)] - hull[k]
        out_x, out_y = normals[k]
        for m in range(counts[k]):
            share = (m + 0.5) / counts[k]
            x, y = start_x + share * dx, start_y + share * dy
            faces = -(x * out_x + y * out_y) > MIN_FACING * np.sqrt(x * x + y * y)
            inside = True
            reads = rises = False
            for distance in PROBES:
                s, t = x + distance * out_x, y + distance * out_y
                px = s * axes[1, 0] + t * axes[2, 0] - offset * axes[0, 0]
                py = s * axes[1, 1] + t * axes[2, 1] - offset * axes[0, 1]
                pz = s * axes[1, 2] + t * axes[2, 2] - offset * axes[0, 2]
                u = np.rint(px / max(pz, 1e-6) * fx + cx)
                v = np.rint(py / max(pz, 1e-6) * fy + cy)
                if pz <= 0 or u < 0 or v < 0 or u >= columns or v >= rows:
                    inside = False
                    continue
                z = np.float64(depth[int(v), int(u)])
                if z <= 0:
                    continue
                reads = True
                qx, qy = (u - cx) / fx * z, (v - cy) / fy * z
                ds = qx * axes[1, 0] + qy * axes[1, 1] + z * axes[1, 2] - s
                dt = qx * axes[2, 0] + qy * axes[2, 1] + z * axes[2, 2] - t
                height = qx * axes[0, 0] + qy * axes[0, 1] + z * axes[0, 2] + offset
                rises |= np.sqrt(ds * ds + dt * dt) < MAX_OFFSET and height > MIN_RISE
            front += faces
            visible += faces and inside
            probed += reads
            rising += rises
    return front, visible, probed, rising

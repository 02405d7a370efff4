"""Detect a support that is enclosed by walls, whether or not the image shows their rims."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

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
    places, outwards = _outline(support.hull.astype(np.float64))
    # The camera is at the origin of the plan.
    towards = -np.einsum("ij,ij->i", places, outwards) / np.linalg.norm(places, axis=1)
    front = towards > MIN_FACING
    visible = front.copy()
    plane, k = support.plane, image.intrinsics
    rows, columns = image.depth.shape
    rises = np.zeros(len(places), bool)
    probed = np.zeros(len(places), bool)
    for distance in PROBES:
        plan = places + distance * outwards
        points = plan @ support.axes - plane.offset * plane.normal
        z = np.maximum(points[:, 2], 1e-6)
        u = np.rint(points[:, 0] / z * k.fx + k.cx)
        v = np.rint(points[:, 1] / z * k.fy + k.cy)
        inside = (points[:, 2] > 0) & (u >= 0) & (v >= 0) & (u < columns) & (v < rows)
        visible &= inside
        u = np.where(inside, u, 0).astype(np.intp)
        v = np.where(inside, v, 0).astype(np.intp)
        depth = np.where(inside, image.depth[v, u], 0.0).astype(np.float64)
        reading = np.column_stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(len(u))])
        reading *= depth[:, None]
        near = np.linalg.norm(reading @ support.axes.T - plan, axis=1) < MAX_OFFSET
        probed |= depth > 0
        rises |= (depth > 0) & near & (plane.height(reading) > MIN_RISE)
    if visible.sum() < MIN_FRONT * front.sum():
        return False
    count = int(np.count_nonzero(probed))
    return bool(count >= MIN_PROBED and np.count_nonzero(rises) >= MIN_RISING_SHARE * count)


def _outline(hull: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places along a hull (K, 2), (N, 2) m, and the outward unit normals there (N, 2)."""
    following = np.roll(hull, -1, axis=0)
    edges = following - hull
    lengths = np.linalg.norm(edges, axis=1)
    counts = np.maximum((lengths / SPACING).astype(np.intp), 1)
    side = np.repeat(np.arange(len(hull)), counts)
    along = np.concatenate([(np.arange(count) + 0.5) / count for count in counts])
    places = hull[side] + along[:, None] * edges[side]
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.maximum(lengths, 1e-9)[:, None]
    inwards = np.einsum("ij,ij->i", normals, hull - hull.mean(axis=0)) < 0
    normals[inwards] *= -1.0
    return places, normals[side]

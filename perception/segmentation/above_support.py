"""Candidate pixels: readings above a support and within reach of the robot."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .connected_parts import connected_parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_extent import Support
    from .working_image import WorkingImage

MIN_HEIGHT = 0.0015
"""Minimum height of an object's points above the support, m, even where it is flat and the camera
has no noise. Paper and cloth are lower."""
BAND_WAVES = 1.5
"""Half width of the band around a support that counts as the support, in heights of its waves. A
lower value includes the foot of objects, and waves beside them."""
SUPPORT_SIGMAS = 3.0
"""The same in σ of its own readings. Both must hold."""
OVERHANG = 0.15
"""Maximum distance of an object's points outside the support's bounds in plan, m. A higher value
keeps more of what extends over the edge, and more of walls and people behind it."""
BOARD = 0.03
"""Minimum distance of an object below a higher support, m: the thickness of boards."""
BLOCK = 8
"""Side of the blocks in which candidates are counted, px."""
MIN_BLOCK = 6
"""Minimum candidates of a block that counts, px. Fewer are noise."""
MARGIN = 2
"""Blocks kept around the candidates, because the windows at their edge need these pixels."""


class SupportZone(NamedTuple):
    """The space above one support, as :func:`mark_above` needs it, camera frame."""

    axes: NDArray[np.float64]
    """The support's normal and its two plan axes as rows, (3, 3)."""
    offset: float
    """Offset of the plane, m."""
    relative_band: float
    """Band above the plane that still counts as the support, divided by squared depth, 1/m."""
    min_height: float
    """Minimum height above the plane, m."""
    low: NDArray[np.float64]
    """Lower bounds in plan, (2,), m."""
    high: NDArray[np.float64]
    """Upper bounds in plan, (2,), m."""
    headroom: float
    """Maximum height of the readings below a higher support, m; 0 for the highest one."""
    under_low: NDArray[np.float64]
    """Lower bounds in plan of the readings below a higher support, (2,), m."""
    under_high: NDArray[np.float64]
    """Upper bounds, (2,), m."""


def above_support(
    image: WorkingImage, supports: list[Support], max_range: float
) -> NDArray[np.bool_]:
    """Mark the readings that may belong to objects, (H, W) bool.

    A candidate is above a support by more than ``MIN_HEIGHT``, the scatter of the support's own
    readings and its waves. In plan it is at most ``OVERHANG`` outside the support's bounds. Below
    a higher support, such as the upper board of a shelf, it lies within the bounds of both and
    ends at least ``BOARD`` below the higher one. Without a support each reading within
    `max_range` m is a candidate.
    """
    depth = image.depth
    if not supports:
        return (depth > 0) & (depth <= np.float32(max_range))
    above = np.zeros(depth.shape, np.bool_)
    below = np.zeros(depth.shape, np.bool_)
    k = image.intrinsics
    rays = (np.arange(k.width) - k.cx) / k.fx, (np.arange(k.height) - k.cy) / k.fy
    # The highest support is nearest to the camera and comes first. It hides what is below it.
    highest = inf
    corners = np.empty((0, 3))
    for support in sorted(supports, key=lambda support: support.plane.offset):
        # The image may cut off the lower board, so the bounds of the higher ones count too.
        corners = np.vstack([corners, support.hull.astype(np.float64) @ support.axes])
        under = corners @ support.axes.T
        zone = SupportZone(
            np.vstack([support.plane.normal, support.axes]),
            support.plane.offset,
            max(
                SUPPORT_SIGMAS * support.plane.tolerance / support.depth**2,
                BAND_WAVES * support.wave,
            ),
            MIN_HEIGHT,
            support.hull.min(axis=0).astype(np.float64) - OVERHANG,
            support.hull.max(axis=0).astype(np.float64) + OVERHANG,
            max(support.plane.offset - highest - BOARD, 0.0),
            under.min(axis=0),
            under.max(axis=0),
        )
        highest = support.plane.offset
        mark_above(depth, rays, zone, max_range, above, below)
    return above


def candidate_window(above: NDArray[np.bool_], min_patch: int) -> tuple[slice, slice] | None:
    """Return the rows and columns around all candidates (H, W), or None if there are too few.

    Connected groups of fewer than `min_patch` px do not count.
    """
    rows, columns = above.shape
    down, across = -(-rows // BLOCK), -(-columns // BLOCK)
    counts = count_blocks(above, down, across, BLOCK)
    parts, _, boxes = connected_parts((counts >= MIN_BLOCK).astype(np.uint8), diagonal=True)
    sizes = np.bincount(parts.ravel(), weights=counts.ravel(), minlength=len(boxes))
    keep = np.flatnonzero(sizes[1:] >= min_patch) + 1
    if keep.size == 0:
        return None
    top, left, bottom, right = boxes[keep].T
    bottom, right = bottom.max(), right.max()
    first_row, first_column = max(top.min() - MARGIN, 0), max(left.min() - MARGIN, 0)
    return (
        slice(int(first_row) * BLOCK, min(int(bottom + MARGIN) * BLOCK, rows)),
        slice(int(first_column) * BLOCK, min(int(right + MARGIN) * BLOCK, columns)),
    )


@njit(cache=True, nogil=True)
def mark_above(depth, rays, zone, max_range, above, below):
    """Mark pixels above one support, but not below an earlier one; then pixels below this one."""
    rows, columns = depth.shape
    rays_u, rays_v = rays
    axes, offset, headroom = zone.axes, zone.offset, zone.headroom
    relative_band, min_height = zone.relative_band, zone.min_height
    left, right, front, back = zone.low[0], zone.high[0], zone.low[1], zone.high[1]
    under_low, under_high = zone.under_low, zone.under_high
    nu, au, bu = axes[0, 0], axes[1, 0], axes[2, 0]
    for v in range(rows):
        n = axes[0, 1] * rays_v[v] + axes[0, 2]
        a = axes[1, 1] * rays_v[v] + axes[1, 2]
        b = axes[2, 1] * rays_v[v] + axes[2, 2]
        row, above_row, below_row = depth[v], above[v], below[v]
        # Without branches the compiler handles several pixels at once.
        for u in range(columns):
            z = np.float64(row[u])
            height = z * (n + nu * rays_u[u]) + offset
            # The errors of a depth camera grow with z², and so does the scatter of a plane.
            band = max(relative_band * z * z, min_height)
            x = z * (a + au * rays_u[u])
            y = z * (b + bu * rays_u[u])
            reachable = (z > 0) & (z <= max_range)
            reachable &= (x >= left) & (x <= right) & (y >= front) & (y <= back)
            under = (x >= under_low[0]) & (x <= under_high[0])
            under &= (y >= under_low[1]) & (y <= under_high[1]) & (height <= headroom)
            reachable &= under | (not below_row[u])
            marked = above_row[u] | (reachable & (height > band))
            above_row[u] = marked
            below_row[u] |= reachable & (not marked)


@njit(cache=True, nogil=True)
def count_blocks(mask, down, across, side):
    """Count the marked pixels of each block of side x side pixels, (down, across)."""
    rows, columns = mask.shape
    counts = np.zeros((down, across), np.int32)
    for v in range(rows):
        for u in range(columns):
            if mask[v, u]:
                counts[v // side, u // side] += 1
    return counts

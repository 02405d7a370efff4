"""What may be an object: readings above a support, within reach of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import SegmentationOptions
    from .support_plane import Support
    from .working_image import View

BLOCK = 8
"""Side of the blocks in which candidates are counted, px."""
MIN_BLOCK = 6
"""Candidates that make a block count, px: fewer are noise."""
MARGIN = 2
"""Blocks kept around the candidates, for the windows at their edge."""


def above_support(
    view: View, supports: list[Support], options: SegmentationOptions
) -> NDArray[np.bool_]:
    """Mark readings that may belong to objects, (H, W) bool.

    A candidate lies higher than ``min_height`` and the waves of the support's own readings above
    a support, not farther than ``overhang`` outside of its hull's bounds in plan, and neither in
    nor under another, higher support: a table's edge and legs stand on the floor. Without a
    support every reading within ``max_range`` is a candidate.
    """
    depth = view.depth
    if not supports:
        return (depth > 0) & (depth <= np.float32(options.max_range))
    above = np.zeros(depth.shape, np.bool_)
    under = np.zeros(depth.shape, np.bool_)
    k = view.intrinsics
    rays_u = (np.arange(k.width) - k.cx) / k.fx
    rays_v = (np.arange(k.height) - k.cy) / k.fy
    # The highest first: what lies below it, in plan, is its own edge and legs.
    for support in sorted(supports, key=lambda support: support.plane.offset):
        low, high = support.hull.min(axis=0), support.hull.max(axis=0)
        mark_above(
            depth,
            rays_u,
            rays_v,
            np.vstack([support.plane.normal, support.axes]),
            support.plane.offset,
            options.plane_sigmas * support.plane.tolerance / support.depth**2,
            options.min_height,
            low.astype(np.float64) - options.overhang,
            high.astype(np.float64) + options.overhang,
            options.max_range,
            above,
            under,
        )
    return above


def candidate_window(
    above: NDArray[np.bool_], options: SegmentationOptions
) -> tuple[slice, slice] | None:
    """Rows and columns that hold all candidates (H, W) worth a look; None when there are none."""
    rows, columns = above.shape
    down, across = -(-rows // BLOCK), -(-columns // BLOCK)
    counts = count_blocks(above, down, across, BLOCK)
    count, parts, stats, _ = cv2.connectedComponentsWithStats(
        (counts >= MIN_BLOCK).astype(np.uint8), connectivity=8
    )
    if count < 2:
        return None
    sizes = np.bincount(parts.ravel(), weights=counts.ravel(), minlength=count)
    keep = np.flatnonzero(sizes[1:] >= options.min_patch) + 1
    if keep.size == 0:
        return None
    left, top, width, height = stats[keep, :4].T
    right, bottom = (left + width).max(), (top + height).max()
    first_row, first_column = max(top.min() - MARGIN, 0), max(left.min() - MARGIN, 0)
    return (
        slice(int(first_row) * BLOCK, min(int(bottom + MARGIN) * BLOCK, rows)),
        slice(int(first_column) * BLOCK, min(int(right + MARGIN) * BLOCK, columns)),
    )


@njit(cache=True, nogil=True)
def mark_above(
    depth,
    rays_u,
    rays_v,
    axes,
    offset,
    waves,
    min_height,
    low,
    high,
    max_range,
    above,
    under,
):
    """Mark what lies above one support but under none before, then what is under this one."""
    rows, columns = depth.shape
    for v in range(rows):
        n = axes[0, 1] * rays_v[v] + axes[0, 2]
        a = axes[1, 1] * rays_v[v] + axes[1, 2]
        b = axes[2, 1] * rays_v[v] + axes[2, 2]
        for u in range(columns):
            z = np.float64(depth[v, u])
            if z <= 0 or z > max_range:
                continue
            height = z * (n + axes[0, 0] * rays_u[u]) + offset
            # A depth camera's errors grow with z²: so does the height of a wave.
            band = max(waves * z * z, min_height)
            x = z * (a + axes[1, 0] * rays_u[u])
            y = z * (b + axes[2, 0] * rays_u[u])
            if x < low[0] or x > high[0] or y < low[1] or y > high[1]:
                continue
            if under[v, u]:
                continue
            if height > band:
                above[v, u] = True
            elif not above[v, u]:
                under[v, u] = True


@njit(cache=True, nogil=True)
def count_blocks(mask, down, across, side):
    """Marked pixels per block of side x side pixels, (down, across)."""
    rows, columns = mask.shape
    counts = np.zeros((down, across), np.int32)
    for v in range(rows):
        for u in range(columns):
            if mask[v, u]:
                counts[v // side, u // side] += 1
    return counts

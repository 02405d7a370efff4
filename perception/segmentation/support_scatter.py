"""The scatter of a support's readings: the noise of single readings, and waves of many."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .median import quantile

if TYPE_CHECKING:
    from .support_extent import Support
    from .working_image import WorkingImage

BLOCK = 8
"""Side of the blocks over which heights are averaged, px at the reference width. Their means show
waves, and not the noise of single readings."""
SAMPLES_ACROSS = 4
"""Readings across a block that are averaged."""
MIN_SHARE = 0.75
"""Minimum share of a block's readings near the support."""
MIN_BLOCKS = 30
"""Minimum number of blocks from which waves are measured."""
NEAR = 0.008
"""Distance from the support within which a reading may belong to it, m."""
LOW_QUANTILE = 0.02
"""Quantile of the mean heights of the blocks that measures waves. Only low blocks are used, because
high ones may show flat objects."""
MAX_SLOPE = 0.75
"""Maximum change of the height along the rows of a block, relative to that of an upright face. The
front edge of a board is an upright face within ``NEAR`` of the board."""
DEFAULT_WAVE = 0.003
"""Waves that are assumed where too few blocks are visible, m."""


def support_wave(image: WorkingImage, support: Support, sigmas: float) -> float:
    """Return how far the waves of a support reach, divided by squared depth, 1/m.

    Waves are bends of the surface, or of the depth of a camera that is not calibrated exactly.
    The height of this many readings side by side differs from 0 alike, so averaging does not help.

    Parameters
    ----------
    image
        The whole image.
    support
        The support.
    sigmas
        Distance from the support, in σ of its readings, within which a reading may belong to it.
    """
    plane, k = support.plane, image.intrinsics
    slope_u = plane.normal[0] * (np.arange(k.width) - k.cx) / k.fx
    slope_v = plane.normal[1] * (np.arange(k.height) - k.cy) / k.fy + plane.normal[2]
    side = image.length(BLOCK)
    band = sigmas * plane.tolerance / support.depth**2
    means = block_heights(
        image.depth,
        (slope_u, slope_v),
        plane.offset,
        (band, MAX_SLOPE * (side // 2) / k.fy),
        (side, max(side // SAMPLES_ACROSS, 1)),
    )
    means = means[np.isfinite(means)]
    if means.size < MIN_BLOCKS:
        return DEFAULT_WAVE / support.depth**2
    return max(-quantile(means, LOW_QUANTILE), 0.0)


@njit(cache=True, nogil=True)
def block_heights(depth, slopes, offset, limits, steps):
    """Return the mean height of each block, divided by squared depth; NaN = not on the support.

    Parameters
    ----------
    depth
        (H, W), m.
    slopes
        Parts of n·ray that depend on the column (W,) and on the row (H,).
    offset
        Offset of the plane, m.
    limits
        Half width of the band around the plane, divided by squared depth, 1/m; maximum difference
        of the heights of the two halves of a block, divided by depth.
    steps
        Side of a block, and distance of its samples, px.
    """
    slope_u, slope_v = slopes
    side, step = steps
    band, max_difference = limits
    middle = side // 2
    down, across = depth.shape[0] // side, depth.shape[1] // side
    means = np.full((down, across), np.nan)
    count = ((side + step - 1) // step) ** 2
    for k in range(down):
        for m in range(across):
            near, total, lower, upper, reach = 0, 0.0, 0.0, 0.0, 0.0
            for v in range(k * side, (k + 1) * side, step):
                for u in range(m * side, (m + 1) * side, step):
                    z = np.float64(depth[v, u])
                    height = z * (slope_u[u] + slope_v[v]) + offset
                    if z > 0 and abs(height) < max(band * z * z, NEAR):
                        near += 1
                        total += height / (z * z)
                        reach += z
                        if v - k * side < middle:
                            upper += height
                        else:
                            lower += height
            level = abs(upper - lower) < 0.5 * max_difference * reach
            if near >= MIN_SHARE * count and level:
                means[k, m] = total / near
    return means

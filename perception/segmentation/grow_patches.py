"""Grow patches: each pixel at their borders joins the patch whose plane fits it best."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .local_planes import STEP_SIGMAS
from .smooth_patches import MIN_PATCH, label_patches

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .working_image import WorkingImage

RIM_SIGMAS = 30.0
"""Maximum distance of a pixel from the plane of the patch it joins in the second pass, in σ. The
rim of a round object is farther from any plane than ``STEP_SIGMAS``. A lower value leaves rims as
patches of their own, a higher one lets thin parts join what is behind them."""


def grow_patches(
    image: WorkingImage,
    planes: LocalPlanes,
    patches: NDArray[np.int32],
    allowed: NDArray[np.bool_],
    window: int,
) -> tuple[NDArray[np.int32], LocalPlanes]:
    """Grow patches over the allowed pixels, and label the pixels that no plane fits.

    Each pass grows the patches by one ring of pixels after the other. A pixel joins the patch
    whose extrapolated plane is nearest to its reading, if this is within ``STEP_SIGMAS``, in a
    second pass within ``RIM_SIGMAS``. It also takes over that plane, which keeps creases sharp.
    Connected pixels that remain become new patches. This keeps thin objects.

    Parameters
    ----------
    image
        Image of all pixels.
    planes
        Its local planes.
    patches
        Labels (H, W), 0 = no patch.
    allowed
        Pixels that may join a patch, (H, W).
    window
        Side of the windows of the plane fit, px: a pass grows by at most twice as many rings.

    Returns
    -------
    patches, planes
        New labels (H, W) int32, and the planes with those that grown pixels took over.
    """
    grown = patches
    for sigmas in (STEP_SIGMAS, RIM_SIGMAS):
        max_gap = np.float32(sigmas * image.noise)
        grown, value, slope_u, slope_v = grow_rings(
            image.disparity, planes, grown, allowed, max_gap, 2 * window
        )
        planes = planes._replace(value=value, slope_u=slope_u, slope_v=slope_v)
    leftover = (allowed & (grown == 0)).astype(np.uint8)
    fresh = label_patches(leftover, image.area(MIN_PATCH))
    grown = np.where(fresh > 0, fresh + grown.max(initial=0), grown).astype(np.int32)
    return grown, planes


@njit(cache=True, nogil=True)
def grow_rings(q, planes, patches, allowed, max_gap, rings):
    """Grow labels by at most `rings` rings; return the labels and the planes' value and slopes.

    Labels and rings are stored in images with a border of one pixel, so that no index has to be
    checked. The border counts as finished.
    """
    rows, columns = q.shape
    value, slope_u, slope_v = planes.value.copy(), planes.slope_u.copy(), planes.slope_v.copy()
    flat = q.ravel(), value.ravel(), slope_u.ravel(), slope_v.ravel()
    width = columns + 2
    finished = rings + 1
    labels = np.zeros((rows + 2, width), np.int32)
    labels[1:-1, 1:-1] = patches
    tried = np.full((rows + 2, width), finished, np.int32)
    for v in range(rows):
        for u in range(columns):
            if patches[v, u] <= 0 and allowed[v, u]:
                tried[v + 1, u + 1] = 0
    padded_labels = labels
    labels, tried = labels.ravel(), tried.ravel()
    queue = np.empty(rows * columns, np.int32)
    end = 0
    for k in range(width, len(labels) - width):
        if labels[k] > 0 and min(tried[k + 1], tried[k - 1], tried[k + width], tried[k - width]) == 0:
            queue[end] = k
            end += 1
    start = 0
    for ring in range(1, rings + 1):
        ring_start = end
        for i in range(start, ring_start):
            for side in (1, -1, width, -width):
                k = queue[i] + side
                if tried[k] >= ring:
                    continue
                tried[k] = ring
                # The rest of this ring ignores negative labels: only earlier rings count.
                labels[k] = -_join_nearest(labels, flat, k, width, max_gap)
                if labels[k] < 0:
                    tried[k] = finished
                    queue[end] = k
                    end += 1
        for i in range(ring_start, end):
            labels[queue[i]] = -labels[queue[i]]
        start = ring_start
        if ring_start == end:
            break
    return padded_labels[1:-1, 1:-1].copy(), value, slope_u, slope_v


@njit(cache=True, nogil=True)
def _join_nearest(labels, flat, k, width, max_gap):
    """Return the label, 0 or more, that pixel k of the padded image joins; set its plane."""
    q, value, slope_u, slope_v = flat
    columns = width - 2
    row = k // width - 1
    pixel = row * columns + k - (row + 1) * width - 1
    best_gap, best_label, best = max_gap, np.int32(0), -1
    best_value = np.float32(0.0)
    for ev in range(-1, 2):
        for eu in range(-1, 2):
            label = labels[k + ev * width + eu]
            other = pixel + ev * columns + eu
            if label <= 0 or value[other] <= 0:
                continue
            at = value[other] - slope_u[other] * eu - slope_v[other] * ev
            gap = abs(at - q[pixel])
            if gap < best_gap:
                best_gap, best_label, best, best_value = gap, label, other, at
    if best >= 0:
        value[pixel], slope_u[pixel], slope_v[pixel] = best_value, slope_u[best], slope_v[best]
    return best_label

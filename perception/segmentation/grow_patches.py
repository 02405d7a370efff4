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
    """Grow labels by at most `rings` rings; return the labels and the planes' value and slopes."""
    rows, columns = q.shape
    labels = patches.copy()
    value, slope_u, slope_v = planes.value.copy(), planes.slope_u.copy(), planes.slope_v.copy()
    queue_v = np.empty(rows * columns, np.int32)
    queue_u = np.empty(rows * columns, np.int32)
    visited = np.zeros((rows, columns), np.int32)
    end = 0
    for v in range(rows):
        for u in range(columns):
            if labels[v, u] > 0 and _can_grow(labels, allowed, v, u):
                queue_v[end] = v
                queue_u[end] = u
                end += 1
    start = 0
    for ring in range(1, rings + 1):
        ring_start = end
        for k in range(start, ring_start):
            for dv, du in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                y, x = queue_v[k] + dv, queue_u[k] + du
                if y < 0 or x < 0 or y >= rows or x >= columns:
                    continue
                if labels[y, x] > 0 or not allowed[y, x] or visited[y, x] == ring:
                    continue
                visited[y, x] = ring
                best_gap = max_gap
                best_label = 0
                best_value = best_u = best_v = np.float32(0.0)
                for ev in range(-1, 2):
                    for eu in range(-1, 2):
                        b, a = y + ev, x + eu
                        if b < 0 or a < 0 or b >= rows or a >= columns:
                            continue
                        if labels[b, a] <= 0 or value[b, a] <= 0:
                            continue
                        at = value[b, a] - slope_u[b, a] * eu - slope_v[b, a] * ev
                        gap = abs(at - q[y, x])
                        if gap < best_gap:
                            best_gap = gap
                            best_label = labels[b, a]
                            best_value = at
                            best_u = slope_u[b, a]
                            best_v = slope_v[b, a]
                if best_label > 0:
                    # The rest of this ring ignores negative labels: only earlier rings count.
                    labels[y, x] = -best_label
                    value[y, x] = best_value
                    slope_u[y, x] = best_u
                    slope_v[y, x] = best_v
                    queue_v[end] = y
                    queue_u[end] = x
                    end += 1
        for k in range(ring_start, end):
            labels[queue_v[k], queue_u[k]] = -labels[queue_v[k], queue_u[k]]
        start = ring_start
        if ring_start == end:
            break
    return labels, value, slope_u, slope_v


@njit(cache=True, nogil=True)
def _can_grow(labels, allowed, v, u):
    """Return whether a pixel has a neighbour in its row or column that may join a patch."""
    rows, columns = labels.shape
    return (
        (u + 1 < columns and allowed[v, u + 1] and labels[v, u + 1] <= 0)
        or (u > 0 and allowed[v, u - 1] and labels[v, u - 1] <= 0)
        or (v + 1 < rows and allowed[v + 1, u] and labels[v + 1, u] <= 0)
        or (v > 0 and allowed[v - 1, u] and labels[v - 1, u] <= 0)
    )

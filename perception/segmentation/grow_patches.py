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

    The images have a border of one pixel, so that no index has to be checked. The value of a pixel
    without a label is infinite, so that nothing joins it.
    """
    rows, columns = q.shape
    width = columns + 2
    labels, tried, readings, value, slope_u, slope_v = _padded(q, planes, patches, allowed, rings)
    surface = readings, value, slope_u, slope_v
    queue = np.empty(rows * columns, np.int32)
    sources = np.empty(rows * columns, np.int32)
    end = 0
    for k in range(width, len(labels) - width):
        if (
            labels[k] > 0
            and min(tried[k + 1], tried[k - 1], tried[k + width], tried[k - width]) == 0
        ):
            queue[end] = k
            end += 1
    start = 0
    for ring in range(1, rings + 1):
        ring_start = end
        for i in range(start, ring_start):
            for side in (1, -1, width, -width):
                k = queue[i] + side
                if tried[k] < ring:
                    tried[k] = ring
                    source = _nearest_plane(surface, k, width, max_gap)
                    if source >= 0:
                        queue[end], sources[end] = k, source
                        end += 1
        # Pixels of one ring do not see each other.
        for i in range(ring_start, end):
            k, source = queue[i], sources[i]
            back = source - k
            down = (back + width + 1) // width - 1
            labels[k], tried[k] = labels[source], rings + 1
            along, across = slope_u[source], slope_v[source]
            value[k] = value[source] - along * (back - down * width) - across * down
            slope_u[k], slope_v[k] = along, across
        start = ring_start
        if ring_start == end:
            break
    return _without_border((labels, value, slope_u, slope_v), planes, rows, columns)


@njit(cache=True, nogil=True)
def _padded(q, planes, patches, allowed, rings):
    """Return labels, rings at which pixels were tried, readings and planes, all flat with a border.

    A pixel that may not join a patch counts as tried in a ring after the last one.
    """
    rows, columns = q.shape
    shape = rows + 2, columns + 2
    labels, tried = np.zeros(shape, np.int32), np.full(shape, rings + 1, np.int32)
    readings, value = np.zeros(shape, np.float32), np.full(shape, np.float32(np.inf))
    slope_u, slope_v = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    for v in range(rows):
        for u in range(columns):
            if patches[v, u] > 0:
                labels[v + 1, u + 1] = patches[v, u]
                if planes.value[v, u] > 0:
                    value[v + 1, u + 1] = planes.value[v, u]
                    slope_u[v + 1, u + 1] = planes.slope_u[v, u]
                    slope_v[v + 1, u + 1] = planes.slope_v[v, u]
            elif allowed[v, u]:
                tried[v + 1, u + 1] = 0
                readings[v + 1, u + 1] = q[v, u]
    surface = readings.ravel(), value.ravel(), slope_u.ravel(), slope_v.ravel()
    return labels.ravel(), tried.ravel(), *surface


@njit(cache=True, nogil=True)
def _nearest_plane(surface, k, width, max_gap):
    """Return the neighbour of pixel k whose plane is nearest to its reading, or -1."""
    q, value, slope_u, slope_v = surface
    best_gap, best = max_gap, -1
    for ev in range(-1, 2):
        for eu in range(-1, 2):
            other = k + ev * width + eu
            gap = abs(value[other] - slope_u[other] * eu - slope_v[other] * ev - q[k])
            nearer = gap < best_gap
            best_gap = gap if nearer else best_gap
            best = other if nearer else best
    return best


@njit(cache=True, nogil=True)
def _without_border(padded, planes, rows, columns):
    """Return labels, value and slopes; unlabelled pixels keep their own planes."""
    width = columns + 2
    flat_labels, flat_value, flat_u, flat_v = padded
    labels = np.zeros((rows, columns), np.int32)
    value, slope_u, slope_v = planes.value.copy(), planes.slope_u.copy(), planes.slope_v.copy()
    for v in range(rows):
        for u in range(columns):
            k = (v + 1) * width + u + 1
            labels[v, u] = flat_labels[k]
            if flat_value[k] < np.inf:
                value[v, u], slope_u[v, u], slope_v[v, u] = flat_value[k], flat_u[k], flat_v[k]
    return labels, value, slope_u, slope_v

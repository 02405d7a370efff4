"""Grow patches: each pixel at their borders joins the patch whose plane fits it best."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .local_planes import STEP_SIGMAS, LocalPlanes
from .smooth_patches import MIN_PATCH, label_patches
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
    max_gaps = np.array([STEP_SIGMAS * image.noise, RIM_SIGMAS * image.noise], np.float32)
    grown, value, slope_u, slope_v = grow_rings(
        image.disparity, planes, patches, allowed, max_gaps, 2 * window
    )
    fresh = label_patches((allowed & (grown == 0)).view(np.uint8), image.area(MIN_PATCH))
    grown += np.where(fresh > 0, fresh + grown.max(initial=0), 0)
    return grown, planes._replace(value=value, slope_u=slope_u, slope_v=slope_v)


@njit(cache=True, nogil=True)
def grow_rings(q, planes, patches, allowed, max_gaps, rings):
    """Grow labels in one pass per gap; return the labels and the planes' value and slopes.

    A pass grows the labels by at most `rings` rings. A pixel joins a patch whose plane misses its
    reading by less than the gap of the pass, 1/m.

    The images have a border of one pixel, so that no index has to be checked. The value of a pixel
    without a label is infinite, so that nothing joins it.
    """
    rows, columns = q.shape
    width = columns + 2
    labels, tried, surface = _padded(q, planes, patches, allowed, rings)
    queue = np.empty(rows * columns, np.int32)
    sources = np.empty(rows * columns, np.int32)
    for max_gap in max_gaps:
        tried = np.where(tried <= rings, 0, rings + 1)
        end = _border_pixels(labels, tried, width, queue)
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
                labels[k], tried[k] = labels[source], rings + 1
                _extend_plane(surface, source, k, width)
            start = ring_start
            if ring_start == end:
                break
    return _without_border(labels, surface, planes, rows, columns)


@njit(cache=True, nogil=True)
def _padded(q, planes, patches, allowed, rings):
    """Return labels, rings at which pixels were tried, and surfaces, all flat with a border.

    A pixel that may not join a patch counts as tried in a ring after the last one. The columns of
    the surfaces (N, 4) are the reading, the value and the slopes of the plane.
    """
    rows, columns = q.shape
    width = columns + 2
    count = (rows + 2) * width
    labels, tried = np.zeros(count, np.int32), np.full(count, rings + 1)
    surface = np.zeros((count, 4), np.float32)
    surface[:, 1] = np.inf
    for v in range(rows):
        for u in range(columns):
            k = (v + 1) * width + u + 1
            if patches[v, u] > 0:
                labels[k] = patches[v, u]
                if planes.value[v, u] > 0:
                    surface[k, 1] = planes.value[v, u]
                    surface[k, 2] = planes.slope_u[v, u]
                    surface[k, 3] = planes.slope_v[v, u]
            elif allowed[v, u]:
                tried[k] = 0
                surface[k, 0] = q[v, u]
    return labels, tried, surface


@njit(cache=True, nogil=True)
def _border_pixels(labels, tried, width, queue):
    """Write the labelled pixels beside an untried one to the queue; return their count."""
    end = 0
    for k in range(width, len(labels) - width):
        if (
            labels[k] > 0
            and min(tried[k + 1], tried[k - 1], tried[k + width], tried[k - width]) == 0
        ):
            queue[end] = k
            end += 1
    return end


@njit(cache=True, nogil=True)
def _nearest_plane(surface, k, width, max_gap):
    """Return the neighbour of pixel k whose plane is nearest to its reading, or -1."""
    best_gap, best = max_gap, -1
    for ev in range(-1, 2):
        for eu in range(-1, 2):
            other = k + ev * width + eu
            predicted = surface[other, 1] - surface[other, 2] * eu - surface[other, 3] * ev
            gap = abs(predicted - surface[k, 0])
            nearer = gap < best_gap
            best_gap = gap if nearer else best_gap
            best = other if nearer else best
    return best


@njit(cache=True, nogil=True)
def _extend_plane(surface, source, k, width):
    """Extend the plane of a pixel to its neighbour k."""
    back = source - k
    down = (back + width + 1) // width - 1
    along, across = surface[source, 2], surface[source, 3]
    surface[k, 1] = surface[source, 1] - along * (back - down * width) - across * down
    surface[k, 2], surface[k, 3] = along, across


@njit(cache=True, nogil=True)
def _without_border(labels, surface, planes, rows, columns):
    """Return labels, value and slopes; unlabelled pixels keep their own planes."""
    width = columns + 2
    result = np.empty((rows, columns), np.int32)
    value, slope_u, slope_v = planes.value.copy(), planes.slope_u.copy(), planes.slope_v.copy()
    for v in range(rows):
        for u in range(columns):
            k = (v + 1) * width + u + 1
            result[v, u] = labels[k]
            if surface[k, 1] < np.inf:
                value[v, u] = surface[k, 1]
                slope_u[v, u], slope_v[v, u] = surface[k, 2], surface[k, 3]
    return result, value, slope_u, slope_v

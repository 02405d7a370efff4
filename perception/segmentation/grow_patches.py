"""Border pixels join the patch whose plane reaches them best."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .smooth_patches import smooth_patches

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .options import SegmentationOptions


def grow_patches(
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    patches: NDArray[np.int32],
    allowed: NDArray[np.bool_],
    options: SegmentationOptions,
) -> tuple[NDArray[np.int32], LocalPlanes]:
    """Spread patches over allowed pixels, ring by ring, and name what no plane reaches.

    Each ring takes the pixels next to a patch; of several patches the one whose extrapolated
    plane lies nearest to the reading wins, if within ``grow_sigmas``, then once more within
    ``rim_sigmas``: the rim of a round solid falls off faster than any plane. A pixel takes its
    patch's plane along, so that creases stay sharp. Connected leftovers become patches of their
    own, which is how thin objects survive.

    Returns
    -------
    patches, planes
        New labels (H, W) int32 and the planes that grown pixels carry.
    """
    grown, value, slope_u, slope_v = patches, planes.value, planes.slope_u, planes.slope_v
    for sigmas in (options.grow_sigmas, options.rim_sigmas):
        grown, value, slope_u, slope_v = grow_rings(
            disparity,
            value,
            slope_u,
            slope_v,
            grown,
            allowed,
            np.float32(sigmas * planes.noise),
            2 * options.window,
        )
    leftover = (allowed & (grown == 0)).astype(np.uint8)
    fresh = smooth_patches(leftover, options.min_patch)
    grown = np.where(fresh > 0, fresh + grown.max(initial=0), grown).astype(np.int32)
    return grown, planes._replace(value=value, slope_u=slope_u, slope_v=slope_v)


@njit(cache=True, nogil=True)
def grow_rings(q, value, slope_u, slope_v, patches, allowed, max_gap, rings):
    """Grow labels ring by ring; see :func:`grow_patches`."""
    rows, columns = q.shape
    labels = patches.copy()
    value, slope_u, slope_v = value.copy(), slope_u.copy(), slope_v.copy()
    queue_v = np.empty(rows * columns, np.int32)
    queue_u = np.empty(rows * columns, np.int32)
    seen = np.zeros((rows, columns), np.int32)
    front = 0
    for v in range(rows):
        for u in range(columns):
            if labels[v, u] > 0:
                queue_v[front] = v
                queue_u[front] = u
                front += 1
    start = 0
    for ring in range(1, rings + 1):
        end = front
        # First mark the pixels of this ring, then decide them from the labels of the last.
        ring_start = front
        for k in range(start, end):
            for dv, du in ((0, 1), (0, -1), (1, 0), (-1, 0)):
                y, x = queue_v[k] + dv, queue_u[k] + du
                if y < 0 or x < 0 or y >= rows or x >= columns:
                    continue
                if labels[y, x] > 0 or not allowed[y, x] or seen[y, x] == ring:
                    continue
                seen[y, x] = ring
                best = max_gap
                chosen = 0
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
                        if gap < best:
                            best = gap
                            chosen = labels[b, a]
                            best_value = at
                            best_u = slope_u[b, a]
                            best_v = slope_v[b, a]
                if chosen > 0:
                    # A negative label is invisible to the rest of this ring.
                    labels[y, x] = -chosen
                    value[y, x] = best_value
                    slope_u[y, x] = best_u
                    slope_v[y, x] = best_v
                    queue_v[front] = y
                    queue_u[front] = x
                    front += 1
        for k in range(ring_start, front):
            labels[queue_v[k], queue_u[k]] = -labels[queue_v[k], queue_u[k]]
        start = end
        if front == end:
            break
    return labels, value, slope_u, slope_v

"""Free space between patches: a straight line inside one convex solid never crosses it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .convexity import SHUFFLE, pixels_by_label

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions

STEPS = 6
"""Parts into which a line is cut; its inner points are looked at."""


def crossings(
    patches: NDArray[np.int32],
    pairs: NDArray[np.int64],
    hollow: NDArray[np.bool_],
    disparity: NDArray[np.float32],
    noise: float,
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> NDArray[np.int64]:
    """Count the lines between patches that cross space seen to be free.

    Parameters
    ----------
    patches
        Labels (H, W), 0 = none.
    pairs
        (K, 2) patch numbers.
    hollow
        (n + 1,): patches that are the inside of something; looking into a vessel past its wall is
        no proof of two solids.
    disparity
        (H, W), 1/m, 0 = no reading.
    noise
        σ of disparity, 1/m.
    camera
        Its intrinsics.
    options
        ``line_samples`` lines a pair; a point is in free space where it lies ``free_depth``
        and ``plane_sigmas`` σ in front of what was measured behind it.

    Returns
    -------
    NDArray
        (K,) number of lines that cross free space.
    """
    order, starts = pixels_by_label(patches, int(patches.max(initial=0)))
    return count_crossings(
        order,
        starts,
        pairs,
        patches,
        hollow,
        disparity,
        (camera.fx, camera.fy, camera.cx, camera.cy),
        options.line_samples,
        options.free_depth,
        options.plane_sigmas * noise,
    )


@njit(cache=True, nogil=True)
def count_crossings(order, starts, pairs, patches, hollow, q, camera, samples, free_depth, margin):
    """Lines of each pair that cross free space; see :func:`crossings`."""
    fx, fy, cx, cy = camera
    columns = q.shape[1]
    counts = np.zeros(len(pairs), np.int64)
    for k in range(len(pairs)):
        a, b = pairs[k]
        size_a, size_b = starts[a + 1] - starts[a], starts[b + 1] - starts[b]
        for i in range(samples):
            # A fixed shuffle pairs every part of one patch with every part of the other.
            j = (i * SHUFFLE + 7) % samples
            pa = order[starts[a] + (2 * i + 1) * size_a // (2 * samples)]
            pb = order[starts[b] + (2 * j + 1) * size_b // (2 * samples)]
            va, ua = pa // columns, pa % columns
            vb, ub = pb // columns, pb % columns
            qa, qb = q[va, ua], q[vb, ub]
            if qa <= 0 or qb <= 0:
                continue
            za, zb = 1.0 / qa, 1.0 / qb
            xa, ya = (ua - cx) / fx * za, (va - cy) / fy * za
            xb, yb = (ub - cx) / fx * zb, (vb - cy) / fy * zb
            for step in range(1, STEPS):
                t = step / STEPS
                z = za + (zb - za) * t
                u = int(np.rint((xa + (xb - xa) * t) / z * fx + cx))
                v = int(np.rint((ya + (yb - ya) * t) / z * fy + cy))
                # Between two pixels of the image a line stays inside it.
                seen = q[v, u]
                if hollow[patches[v, u]]:
                    continue
                if seen > 0 and seen + margin < 1.0 / (z + free_depth):
                    counts[k] += 1
                    break
    return counts

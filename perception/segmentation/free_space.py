"""Free space between patches: a straight line inside one convex solid never crosses it."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import LINES, LabelPixels, line_end, pixels_by_label, sample_pixel
from .working_image import WorkingImage

FREE_DEPTH = 0.003
"""Minimum distance of a point in free space from the surface behind it, m."""
FREE_SIGMAS = 3.0
"""Further minimum distance, in σ of the noise of disparity. It is added to ``FREE_DEPTH``."""
LINE_PARTS = 6
"""Number of equal parts of a line. The ``LINE_PARTS - 1`` points between the parts are tested."""


def count_free_lines(
    patches: NDArray[np.int32],
    pairs: NDArray[np.int64],
    hollow: NDArray[np.bool_],
    image: WorkingImage,
    pixels: LabelPixels | None = None,
) -> NDArray[np.int64]:
    """Count the lines between patches that cross free space.

    Parameters
    ----------
    patches
        Labels (H, W), 0 = no patch.
    pairs
        Labels of the two patches of each pair, (K, 2). ``LINES`` lines are tested for each pair.
    hollow
        (n + 1,) bool: patches that are the inside of a vessel. A line in front of them may cross
        free space although its ends belong to one object. The points of a line in front of such
        a patch are not tested.
    image
        Image of the patches.
    pixels
        Pixels of the patches, if the caller has them.

    Returns
    -------
    NDArray
        Number of lines that cross free space, (K,).
    """
    pixels = pixels or pixels_by_label(patches, int(patches.max(initial=0)))
    margin = FREE_SIGMAS * image.noise
    return count_crossings(
        pixels, pairs, patches, hollow, image.disparity, image.pinhole, margin, LINES
    )


@njit(cache=True, nogil=True)
def count_crossings(pixels, pairs, patches, hollow, q, pinhole, margin, lines):
    """Count for each pair how many of its `lines` lines cross free space.

    `q` is the disparity (H, W), and `margin` its tolerance, 1/m.
    """
    fx, fy, cx, cy = pinhole
    columns = q.shape[1]
    counts = np.zeros(len(pairs), np.int64)
    for k in range(len(pairs)):
        for i in range(lines):
            pa = sample_pixel(pixels, pairs[k, 0], i, lines)
            pb = sample_pixel(pixels, pairs[k, 1], line_end(i, lines), lines)
            va, ua = pa // columns, pa % columns
            vb, ub = pb // columns, pb % columns
            qa, qb = q[va, ua], q[vb, ub]
            if qa <= 0 or qb <= 0:
                continue
            za, zb = 1.0 / qa, 1.0 / qb
            xa, ya = (ua - cx) / fx * za, (va - cy) / fy * za
            xb, yb = (ub - cx) / fx * zb, (vb - cy) / fy * zb
            for step in range(1, LINE_PARTS):
                t = step / LINE_PARTS
                z = za + (zb - za) * t
                # A line between two pixels of the image stays inside the image.
                u = int(np.rint((xa + (xb - xa) * t) / z * fx + cx))
                v = int(np.rint((ya + (yb - ya) * t) / z * fy + cy))
                measured = q[v, u]
                if hollow[patches[v, u]]:
                    continue
                if measured > 0 and measured + margin < 1.0 / (z + FREE_DEPTH):
                    counts[k] += 1
                    break
    return counts

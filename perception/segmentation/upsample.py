"""Convert the labels of a reduced image to the frame's own size."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def upsample_labels(
    labels: NDArray[np.int32], disparity: NDArray[np.float32], stride: int
) -> NDArray[np.int32]:
    """Assign to each reading the label of the coarse neighbour nearest in disparity, out of four.

    This is joint bilateral upsampling (Kopf et al. 2007): outlines follow the frame's depth steps.

    Parameters
    ----------
    labels
        (ceil(H / stride), ceil(W / stride)), of the pixels (0, stride, 2 stride, …).
    disparity
        (H, W), 1/m, 0 = no reading.
    stride
        Rows and columns between labelled pixels.

    Returns
    -------
    NDArray
        (H, W) int32; 0 where there is no reading.
    """
    return nearest_labels(labels, disparity, stride)


@njit(cache=True, nogil=True)
def nearest_labels(labels, q, stride):
    """Compute :func:`upsample_labels`."""
    rows, columns = q.shape
    down, across = labels.shape
    full = np.zeros((rows, columns), np.int32)
    for k in range(down):
        below = min(k + 1, down - 1)
        for m in range(across):
            right = min(m + 1, across - 1)
            label = labels[k, m]
            same = labels[k, right] == label
            same &= (labels[below, m] == label) & (labels[below, right] == label)
            if same and label == 0:
                continue
            same &= q[k * stride, m * stride] > 0
            for v in range(k * stride, min((k + 1) * stride, rows)):
                for u in range(m * stride, min((m + 1) * stride, columns)):
                    if q[v, u] > 0:
                        corners = (k, below), (m, right)
                        full[v, u] = label if same else _nearest(labels, q, stride, (v, u), corners)
    return full


@njit(cache=True, nogil=True)
def _nearest(labels, q, stride, pixel, corners):
    """Return the label of the corner nearest to a pixel in disparity, 0 without a reading."""
    (top, bottom), (left, right) = corners
    here = q[pixel[0], pixel[1]]
    best, found = np.float32(np.inf), np.int32(0)
    for y in range(top, bottom + 1):
        for x in range(left, right + 1):
            at = q[y * stride, x * stride]
            if at > 0 and abs(at - here) < best:
                best = abs(at - here)
                found = labels[y, x]
    return found

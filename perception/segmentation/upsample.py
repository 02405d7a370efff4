"""Convert the labels of a reduced image to the frame's own size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numba import njit

if TYPE_CHECKING:
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
    for v in range(rows):
        for u in range(columns):
            k, m = v // stride, u // stride
            below, right = min(k + 1, down - 1), min(m + 1, across - 1)
            if q[v, u] <= 0 or not (
                labels[k, m] or labels[k, right] or labels[below, m] or labels[below, right]
            ):
                continue
            best = np.float32(np.inf)
            for y in range(k, below + 1):
                for x in range(m, right + 1):
                    at = q[y * stride, x * stride]
                    if at <= 0:
                        continue
                    gap = abs(at - q[v, u])
                    if gap < best:
                        best = gap
                        full[v, u] = labels[y, x]
    return full

"""The median of few numbers."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def median(values):
    """Return the median of numbers (N,), N > 0.

    The result equals the one of ``np.median``. For 300 numbers that function takes 30 µs, and this
    one 3 µs. The segmentation computes some hundred medians per frame.
    """
    return np.median(values)

"""The median and the quantiles of few numbers."""

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


@njit(cache=True, nogil=True)
def quantile(values, share):
    """Return a quantile of finite numbers (N,), N > 0, for a share from 0 to 1.

    The result equals the one of ``np.quantile`` for float64. For 300 numbers that function takes
    27 µs, and this one 3 µs.
    """
    ordered = np.sort(values)
    place = share * (len(values) - 1)
    below = int(place)
    rest = place - below
    low, high = ordered[below], ordered[min(below + 1, len(values) - 1)]
    step = high - low
    # NumPy interpolates from the nearer end.
    return high - step * (1.0 - rest) if rest >= 0.5 else low + step * rest

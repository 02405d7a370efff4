"""Robust statistics of residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


def robust_spread(residuals: NDArray[np.float64]) -> float:
    """Return the robust standard deviation of residuals (N,); infinite for none."""
    if residuals.size == 0:
        return float("inf")
    return float(MAD_TO_SIGMA * np.median(np.abs(residuals)))

"""Robust statistics of residuals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MAD_TO_SIGMA = 1.4826
"""Ratio of standard deviation to median absolute deviation of a normal distribution."""


def robust_spread(residuals: NDArray[np.float64]) -> float:
    """Return the robust standard deviation of residuals (N,); infinite for none."""
    if residuals.size == 0:
        return float("inf")
    # np.median takes twice the time of a partition.
    middle = (residuals.size - 1) // 2, residuals.size // 2
    ordered = np.partition(np.abs(residuals).ravel(), middle)
    return float(MAD_TO_SIGMA * 0.5 * (ordered[middle[0]] + ordered[middle[1]]))


def robust_square(residuals: NDArray[np.float64], noise: float) -> float:
    """Return the mean square of residuals (N,) with the Cauchy loss of the fit.

    The unit of the result is the square of that of the residuals and of the expected noise.
    """
    return float(np.mean(robust_squares(residuals, noise)))


def robust_squares(residuals: NDArray[np.float64], noise: float) -> NDArray[np.float64]:
    """Return twice the Cauchy loss (N,) of each residual; see :func:`robust_square`."""
    scale = 2.0 * noise
    return scale**2 * np.log1p((residuals / scale) ** 2)


def log_square(residuals: NDArray[np.float64], noise: float) -> float:
    """Return the log of the robust mean square with the noise floor of the model selection."""
    return float(np.log(robust_square(residuals, noise) + (0.5 * noise) ** 2))

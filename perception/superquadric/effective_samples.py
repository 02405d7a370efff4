"""Effective number of independent samples among points whose residuals are correlated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .neighbour_kernels import nearest_neighbours
from .robust import robust_spread

PATCH_SIZE = 30
"""Neighbours of a patch: wide enough for the blur of a camera and the waves of a surface."""
PATCHES = 150
"""Points whose patches are evaluated."""
CLIP = 3.0
"""Residuals are clipped at this many robust standard deviations, against outliers."""
MIN_SAMPLES = 40.0
"""With fewer samples any simple solid would pass for any cloud."""
MAX_SAMPLES = 150.0
"""With more samples a criterion would select richer solids on too little evidence."""
TRUSTED_SHARE = 0.5
"""Factor on the estimate, because errors are also correlated beyond a patch. With 0.5 the kinds of
simple solids under correlated depth noise were most often right."""


def effective_sample_size(
    points: NDArray[np.float64],
    residuals: NDArray[np.float64],
    max_samples: float = MAX_SAMPLES,
) -> float:
    """Estimate the number of independent samples in residuals (N,) at points (N, 3), any unit.

    With ρ the mean correlation of a residual with those of its patch, N points count as
    N/(1 + PATCH_SIZE ρ) independent ones (variance of a mean of equally correlated samples).
    The result lies between MIN_SAMPLES and `max_samples`.
    """
    if len(points) <= 2 * PATCH_SIZE:
        return float(np.clip(TRUSTED_SHARE * len(points), MIN_SAMPLES, max_samples))
    limit = CLIP * robust_spread(residuals)
    residuals = np.clip(residuals, -limit, limit)
    square = float(np.mean(residuals**2))
    if square == 0.0:
        return max_samples
    _, patches = nearest_neighbours(points, points[:PATCHES], PATCH_SIZE + 1)
    correlation = float(np.mean(residuals[:PATCHES, None] * residuals[patches[:, 1:]])) / square
    samples = TRUSTED_SHARE * len(points) / (1.0 + PATCH_SIZE * max(correlation, 0.0))
    return float(np.clip(samples, MIN_SAMPLES, max_samples))

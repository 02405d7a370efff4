"""How many independent readings a cloud holds: neighbours whose residuals agree count once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import KDTree

from .cost_kernels import distances
from .result import robust_spread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import FitOptions
    from .problem import FitProblem, Guess

PATCH = 30
"""Neighbours that make up a patch: wide enough for a camera's blur and a surface's waves."""
SAMPLES = 150
"""Points whose patches are looked at."""
CLIP = 3.0
"""Residuals beyond so many spreads say as much as this: one outlier is no agreement."""
FEWEST = 40.0
"""Fewer would let any simple solid pass for any cloud."""
BELIEVED = 0.5
"""Share of the estimate that is believed: errors agree beyond a patch too. Measured: the kinds of
simple solids under correlated depth noise come out right most often at this share."""


def independent_readings(problem: FitProblem, guess: Guess, options: FitOptions) -> float:
    """Estimate the independent readings in a problem's points from residuals about a solid.

    With ρ the mean correlation of a residual with those of its patch, N points say as much as
    N/(1 + PATCH ρ) independent ones (the variance of a mean of equally correlated readings).
    """
    return readings_of(problem.points, distances(problem.points, *guess), options)


def readings_of(
    points: NDArray[np.float64], residuals: NDArray[np.float64], options: FitOptions
) -> float:
    """Estimate the independent readings in points (N, 3) from residuals (N,); any one unit."""
    if len(points) <= 2 * PATCH:
        return float(np.clip(BELIEVED * len(points), FEWEST, options.effective_points))
    limit = CLIP * robust_spread(residuals)
    residuals = np.clip(residuals, -limit, limit)
    square = float(np.mean(residuals**2))
    if square == 0.0:
        return options.effective_points
    patches = np.asarray(KDTree(points).query(points[:SAMPLES], k=PATCH + 1)[1])
    agreement = float(np.mean(residuals[:SAMPLES, None] * residuals[patches[:, 1:]])) / square
    readings = BELIEVED * len(points) / (1.0 + PATCH * max(agreement, 0.0))
    return float(np.clip(readings, FEWEST, options.effective_points))

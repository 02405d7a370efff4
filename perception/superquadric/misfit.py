"""Correlated part of the residuals of a fit: the distance of the surface from its model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

PATCH_SIZE = 20
"""Neighbours of a patch. Their noise averages out; the distance of the surface does not."""
PATCHES = 200
"""Points whose patches are evaluated."""
CLIP = 3.0
"""Residuals are clipped at this many robust standard deviations, against outliers."""


def correlated_misfit(
    points: NDArray[np.float64], normals: NDArray[np.float64], residuals: NDArray[np.float64]
) -> tuple[float, float]:
    """Separate the residuals of a model into the model's misfit and the noise of the points.

    The misfit is the square root of the mean product of a residual and those of its neighbours.
    Neighbours are those of the points projected onto the model. Neighbours of the points
    themselves would have similar noise, because noise moves points towards each other.

    Parameters
    ----------
    points
        (N, 3) in random order, m.
    normals
        (N, 3) unit normals of the model at the points.
    residuals
        (N,) signed distances of the points from the model, m.

    Returns
    -------
    misfit, noise
        Standard deviations, m. The misfit is 0 with fewer points than two patches.
    """
    limit = CLIP * 1.4826 * float(np.median(np.abs(residuals)))
    clipped = np.clip(residuals, -limit, limit)
    square = float(np.mean(clipped**2))
    if len(points) <= 2 * PATCH_SIZE:
        return 0.0, float(np.sqrt(square))
    flat = points - residuals[:, None] * normals
    patches = np.asarray(KDTree(flat).query(flat[:PATCHES], k=PATCH_SIZE + 1)[1])
    product = float(np.mean(clipped[:PATCHES, None] * clipped[patches[:, 1:]]))
    product = min(max(product, 0.0), square)
    return float(np.sqrt(product)), float(np.sqrt(square - product))

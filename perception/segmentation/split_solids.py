"""Split an object where two solids fit it clearly better than one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..superquadric import FitOptions, fit_superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .working_image import WorkingImage

MIN_GAIN = 2.0
"""Minimum ratio of the spread about one solid to the spread about two."""
MIN_SPREAD = 0.004
"""Minimum spread about one solid for an object to be split, m."""
SAMPLES = 600
"""Points of an object to which the solids are fitted."""
ONE_SOLID = FitOptions(max_parts=1)
"""Options of these fits: the halves are compared with one solid."""
ROUNDS = 10
"""Iterations of the two means. More change nothing."""


def split_mask(
    mask: NDArray[np.bool_], image: WorkingImage, min_object: int
) -> NDArray[np.bool_] | None:
    """Return the pixels (H, W) of the second solid, or None where one solid fits well enough.

    The k-means algorithm with two means proposes the halves. It starts from the two sides of the
    centroid along the main axis. The simplest solid is fitted to the whole and to each half, of
    at least `min_object` px.
    """
    rows, columns = np.nonzero(mask & (image.disparity > 0))
    points = image.points(rows, columns)
    second = _second_half(points)
    if min(np.count_nonzero(second), np.count_nonzero(~second)) < min_object:
        return None
    whole = _spread(points)
    if whole < MIN_SPREAD:
        return None
    halves = max(_spread(points[second]), _spread(points[~second]))
    if whole < MIN_GAIN * halves:
        return None
    second_mask = np.zeros(mask.shape, bool)
    second_mask[rows[second], columns[second]] = True
    return second_mask


def _spread(points: NDArray[np.float64]) -> float:
    sample = points[:: max(len(points) // SAMPLES, 1)]
    fit = fit_superquadric(sample, view_origin=np.zeros(3), options=ONE_SOLID)
    return fit.spread if fit else np.inf


def _second_half(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Divide points (N, 3) by two means; return the mask of one half."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    second = centred @ axes[:, -1] > 0
    for _ in range(ROUNDS):
        if second.all() or not second.any():
            break
        a, b = points[~second].mean(axis=0), points[second].mean(axis=0)
        second = ((points - b) ** 2).sum(axis=1) < ((points - a) ** 2).sum(axis=1)
    return second

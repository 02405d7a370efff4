"""Split an object with two plain colours at the plane between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .working_image import WorkingImage

MIN_CONTRAST = 0.08
"""Minimum distance of the two colours, in shares of red, green and blue. A lower value splits
where coloured light falls on one face more than on another."""
MIN_PURITY = 0.85
"""Minimum share of an object's colour variance that two plain colours explain. A lower value splits
printed boxes."""
MIN_STRAIGHTNESS = 0.96
"""Minimum share of the pixels that one plane puts on the side of their colour."""
SAMPLES = 600
"""Pixels of an object on which its colours are compared."""
DARK = 45.0
"""Sum of red, green and blue below which the colour of a pixel is unreliable."""
MIN_SHARE = 0.12
"""Minimum share of an object on either side of the edge. A smaller part is a label or a lid."""
STEPS = 32
"""Thresholds tried between two colours, and between two positions."""


def colour_cut(mask: NDArray[np.bool_], image: WorkingImage) -> NDArray[np.bool_] | None:
    """Find the plane in space at which a two-coloured object changes its colour.

    Parameters
    ----------
    mask
        Pixels of the object, (H, W).
    image
        Its image.

    Returns
    -------
    NDArray or None
        Pixels on one side of the plane, (H, W) bool. None without colour, and unless the object
        has two plain colours that a plane separates. Prints have more colours or curved edges.
    """
    if image.colour is None:
        return None
    rows, columns = np.nonzero(mask & (image.disparity > 0))
    step = max(rows.size // SAMPLES, 1)
    v, u = rows[::step], columns[::step]
    if v.size < STEPS:
        return None
    # Shares of red, green and blue do not change with light and shade.
    values = image.colour[v, u].astype(np.float64)
    total = values.sum(axis=1)
    if np.mean(total < DARK) > MIN_SHARE / 2:
        return None
    values /= np.maximum(total, DARK)[:, None]
    first = _first_colour(values)
    if first is None:
        return None
    points = image.points(v, u)
    # Fisher's discriminant: the direction in space that separates the two colours best.
    difference = points[first].mean(axis=0) - points[~first].mean(axis=0)
    within = np.cov(points[first].T) + np.cov(points[~first].T)
    normal = np.linalg.solve(within + 1e-9 * np.eye(3), difference)
    along = points @ normal
    cuts = np.quantile(along, np.linspace(0, 1, STEPS + 2)[1:-1])
    correct = [np.mean((along > cut) == first) for cut in cuts]
    best = int(np.argmax(correct))
    if correct[best] < MIN_STRAIGHTNESS:
        return None
    side = np.zeros(mask.shape, bool)
    side[rows, columns] = image.points(rows, columns) @ normal > cuts[best]
    return side


def _first_colour(values: NDArray[np.float64]) -> NDArray[np.bool_] | None:
    """Split colours (N, 3) at the best threshold along their main axis (Otsu 1979)."""
    centred = values - values.mean(axis=0)
    total = float((centred**2).sum())
    # The variance of two classes with the minimum share and contrast.
    if total < len(values) * MIN_SHARE * (1 - MIN_SHARE) * MIN_CONTRAST**2:
        return None
    _, axes = np.linalg.eigh(centred.T @ centred)
    along = centred @ axes[:, -1]
    order = np.argsort(-along)
    sums = np.cumsum(centred[order], axis=0)
    cuts = np.linspace(along.min(), along.max(), STEPS + 2)[1:-1]
    above = np.searchsorted(-along[order], -cuts)
    share = above / len(values)
    # The mean of the whole is 0, so one class' mean gives the distance of both.
    gap = np.square(sums[above - 1]).sum(axis=1) / np.square(above * (1 - share))
    allowed = (share >= MIN_SHARE) & (share <= 1 - MIN_SHARE) & (gap >= MIN_CONTRAST**2)
    between = np.where(allowed, len(values) * share * (1 - share) * gap, 0.0)
    best = int(np.argmax(between))
    return along > cuts[best] if between[best] >= max(MIN_PURITY * total, 1e-9) else None

"""Find the objects that look like a part of a wall, a board or a floor."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .label_pixels import pixels_by_label
from .point_extent import box_diagonal, trimmed_range
from .select_objects import sample_region
from .working_image import WorkingImage

MIN_LENGTH = 0.15
"""Minimum length of a sheet, m. Smaller flat objects are common."""
MAX_THICKNESS = 0.1
"""Maximum extent of a sheet across its plane, as a share of its length."""
MIN_SOLIDITY = 0.6
"""Minimum share of its convex outline that an object of this length fills. What remains of a floor
between objects, or of a wall behind them, fills less."""
OUTLIERS = 0.03
"""Share of a region's readings beyond each end of its extent."""


def find_sheets(labels: NDArray[np.int32], image: WorkingImage) -> tuple[int, ...]:
    """Return the labels of the objects of which only a long thin sheet is visible.

    Walls, boards and floors that were not recognised are such sheets.

    Parameters
    ----------
    labels
        Objects 1..n (H, W).
    image
        Their image.
    """
    count = int(labels.max(initial=0))
    order, starts = pixels_by_label(np.ascontiguousarray(labels), count)
    found = []
    for label in range(1, count + 1):
        pixels = order[starts[label] : starts[label + 1]]
        points, _ = sample_region(pixels, image.disparity, image.pinhole)
        if len(points) > 2 and _is_sheet(points, pixels, labels.shape[1]):
            found.append(label)
    return tuple(found)


def _is_sheet(points: NDArray[np.float64], pixels: NDArray[np.int32], columns: int) -> bool:
    if box_diagonal(points) < MIN_LENGTH:
        return False
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    # The axis of the greatest spread is the last one.
    across, length = (
        np.subtract(*trimmed_range(centred @ axes[:, k], OUTLIERS)[::-1]) for k in (0, 2)
    )
    if length < MIN_LENGTH:
        return False
    if across <= MAX_THICKNESS * length:
        return True
    places = np.column_stack([pixels % columns, pixels // columns])
    return len(pixels) < MIN_SOLIDITY * cv2.contourArea(cv2.convexHull(places.astype(np.int32)))

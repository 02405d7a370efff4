"""Two solids instead of one, where two explain an object clearly better."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..superquadric import fit_superquadric

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions

SAMPLES = 600
"""Points of an object on which one solid and two are compared."""
ROUNDS = 10
"""Steps of the two means: more change nothing."""


def split_mask(
    mask: NDArray[np.bool_],
    disparity: NDArray[np.float32],
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> NDArray[np.bool_] | None:
    """Pixels (H, W) of the second solid, or None where one explains the object as well.

    Two means of the points, started at the ends of their main axis, propose the halves; each
    half and the whole are fitted with the simplest solid. Two win when the whole's spread is more
    than ``split_gain`` times that of the halves, and above ``split_spread``.
    """
    rows, columns = np.nonzero(mask & (disparity > 0))
    z = 1.0 / disparity[rows, columns].astype(np.float64)
    points = np.column_stack(
        [(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z]
    )
    second = _two_means(points)
    if min(np.count_nonzero(second), np.count_nonzero(~second)) < options.min_object:
        return None
    whole = _spread(points)
    if whole < options.split_spread:
        return None
    halves = max(_spread(points[second]), _spread(points[~second]))
    if whole < options.split_gain * halves:
        return None
    found = np.zeros(mask.shape, bool)
    found[rows[second], columns[second]] = True
    return found


def _spread(points: NDArray[np.float64]) -> float:
    sample = points[:: max(len(points) // SAMPLES, 1)]
    fit = fit_superquadric(sample, view_origin=np.zeros(3))
    return fit.spread if fit else np.inf


def _two_means(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    second = centred @ axes[:, -1] > 0
    for _ in range(ROUNDS):
        if second.all() or not second.any():
            break
        a, b = points[~second].mean(axis=0), points[second].mean(axis=0)
        second = ((points - b) ** 2).sum(axis=1) < ((points - a) ** 2).sum(axis=1)
    return second

"""A colour edge through a solid that geometry alone takes for one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions

SAMPLES = 600
"""Pixels of an object on which its colours are compared."""
DARK = 45.0
"""Sum of red, green and blue below which a pixel has no colour to speak of."""
MIN_SHARE = 0.12
"""Least share of an object on either side of the edge: less is a label or a lid."""
STEPS = 32
"""Thresholds tried between two colours, and between two places."""


def colour_cut(
    mask: NDArray[np.bool_],
    disparity: NDArray[np.float32],
    colour: NDArray[np.uint8],
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> NDArray[np.bool_] | None:
    """Find the plane in space at which a two-coloured object changes its colour.

    Parameters
    ----------
    mask
        Pixels of the object, (H, W).
    disparity
        (H, W), 1/m.
    colour
        (H, W, 3) uint8 RGB.
    camera
        Its intrinsics.
    options
        ``colour_contrast``, ``colour_purity``, ``colour_straightness``.

    Returns
    -------
    NDArray or None
        Pixels on the far side, (H, W) bool; None unless the object has two plain colours that
        one plane separates: prints and pictures have more colours, or crooked edges.
    """
    rows, columns = np.nonzero(mask & (disparity > 0))
    step = max(rows.size // SAMPLES, 1)
    v, u = rows[::step], columns[::step]
    if v.size < STEPS:
        return None
    # Shares of red, green and blue: light and shade change all three alike.
    values = colour[v, u].astype(np.float64)
    total = values.sum(axis=1)
    if np.mean(total < DARK) > MIN_SHARE / 2:
        return None
    values /= np.maximum(total, DARK)[:, None]
    first = _two_classes(values, options)
    if first is None:
        return None
    points = _points(v, u, disparity, camera)
    # Fisher's discriminant: the direction in space that tells the two colours apart best.
    apart = points[first].mean(axis=0) - points[~first].mean(axis=0)
    within = np.cov(points[first].T) + np.cov(points[~first].T)
    normal = np.linalg.solve(within + 1e-9 * np.eye(3), apart)
    along = points @ normal
    cuts = np.quantile(along, np.linspace(0, 1, STEPS + 2)[1:-1])
    right = [np.mean((along > cut) == first) for cut in cuts]
    best = int(np.argmax(right))
    if right[best] < options.colour_straightness:
        return None
    side = np.zeros(mask.shape, bool)
    side[rows, columns] = _points(rows, columns, disparity, camera) @ normal > cuts[best]
    return side


def _two_classes(
    values: NDArray[np.float64], options: SegmentationOptions
) -> NDArray[np.bool_] | None:
    """Split colours (N, 3) at the best threshold along their main axis (Otsu 1979)."""
    centred = values - values.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    along = centred @ axes[:, -1]
    total = float((centred**2).sum())
    # Two classes of these shares and this contrast vary at least as much.
    if total < len(values) * MIN_SHARE * (1 - MIN_SHARE) * options.colour_contrast**2:
        return None
    best, chosen = 0.0, None
    for cut in np.linspace(along.min(), along.max(), STEPS + 2)[1:-1]:
        first = along > cut
        share = float(first.mean())
        if not MIN_SHARE <= share <= 1 - MIN_SHARE:
            continue
        # The classes' means lie as far from the whole's as their shares are small.
        gap = centred[first].mean(axis=0) / (1 - share)
        between = len(values) * share * (1 - share) * float(gap @ gap)
        if gap @ gap >= options.colour_contrast**2 and between > best:
            best, chosen = between, first
    return chosen if best >= options.colour_purity * total else None


def _points(
    v: NDArray[np.intp],
    u: NDArray[np.intp],
    disparity: NDArray[np.float32],
    camera: CameraIntrinsics,
) -> NDArray[np.float64]:
    z = 1.0 / disparity[v, u].astype(np.float64)
    return np.column_stack([(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z])

"""Regions in the air: robots, hands and lamps, below which the camera sees free space."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .label_pixels import pixels_by_label, renumber_labels
from .median import quantile
from .regions import LOW_QUANTILE, MAX_REGIONS
from .result import SupportPlane
from .select_objects import sample_region
from .select_supports import is_floor
from .support_extent import Support
from .working_image import WorkingImage

MIN_BOTTOM = 0.12
"""Minimum height of a floating region's lowest visible part above the next support below it, m.
Objects in heaps reach 0.12 m."""
STEPS = (0.015, 0.03, 0.045, 0.06, 0.08)
"""Distances below a region at which free space is tested, m."""
MARGIN = 0.02
"""Minimum depth of a reading behind free space, m."""
MIN_FREE = 0.45
"""Minimum share of a region's points with free space below them, and nothing else. It is 0.46 or
more for parts of robots, and at most 0.37 for objects in clutter and heaps."""
MAX_DISTANCE = 0.03
"""Maximum distance of a region from one that carries it, in height and in plan, m. An object may
overhang another one."""
MAX_FOOT = 0.06
"""Maximum height of the lowest visible part of a region that carries another one, m. The parts of a
robot in the air touch each other."""
MAX_BELOW_SUPPORT = 0.03
"""Maximum depth of a region's lowest part below the support under it, m."""


def remove_floating(
    labels: NDArray[np.int32], image: WorkingImage, supports: list[Support]
) -> NDArray[np.int32]:
    """Remove the regions that hang in the air and that no other region carries.

    With several work surfaces all regions stay: in a shelf, an object in the air may stand on a
    board that was not found.

    Parameters
    ----------
    labels
        Regions (H, W) int32, numbered by size: 1..n, 0 = none.
    image
        Their image.
    supports
        The supports.

    Returns
    -------
    NDArray
        (H, W) int32: the other regions, numbered by size.
    """
    surfaces = [support for support in supports if not is_floor(support, supports[0])]
    count = int(labels.max(initial=0))
    if len(surfaces) != 1 or count == 0:
        return labels
    order, starts = pixels_by_label(labels, count)
    points = {
        label: sample_region(
            order[starts[label] : starts[label + 1]], image.disparity, image.pinhole
        )[0]
        for label in range(1, min(count, MAX_REGIONS) + 1)
    }
    aloft = [one for one in points if _floats(points[one], one, labels, image, supports)]
    standing = [points[one] for one in points if one not in aloft]
    plane = supports[0].plane
    removed = [one for one in aloft if not _is_carried(points[one], standing, plane)]
    if not removed:
        return labels
    kept = np.setdiff1d(np.arange(1, count + 1), removed)
    numbers = np.zeros(count + 1, np.int32)
    numbers[kept] = np.arange(1, len(kept) + 1)
    return renumber_labels(labels, numbers)


def _floats(
    points: NDArray[np.float64],
    label: int,
    labels: NDArray[np.int32],
    image: WorkingImage,
    supports: list[Support],
) -> bool:
    """Return whether a region hangs in the air, high above all supports.

    Where the camera sees a surface behind the space below a point, nothing carries this point. Of
    an object that stands, the camera sees a side, the support at its foot, or what it stands on.

    Parameters
    ----------
    points
        Points of the region (N, 3), m, camera frame.
    label
        Its label.
    labels
        Regions (H, W).
    image
        Their image.
    supports
        The supports. Without any, nothing floats.
    """
    if not len(points) or not supports:
        return False
    bottoms = [quantile(one.plane.height(points), LOW_QUANTILE) for one in supports]
    if min((b for b in bottoms if b > -MAX_BELOW_SUPPORT), default=0.0) < MIN_BOTTOM:
        return False
    below = points[:, None] - np.array(STEPS)[:, None] * supports[0].plane.normal
    pixels = image.intrinsics.project(below)
    last = np.array(image.disparity.shape[::-1]) - 1
    # NaN behind the camera fails the comparisons.
    inside = np.all((pixels >= 0) & (pixels <= last), axis=-1)
    columns, rows = (
        np.where(inside[..., None], pixels, 0).round().astype(np.intp).transpose(2, 0, 1)
    )
    with np.errstate(divide="ignore"):
        behind = 1.0 / image.disparity[rows, columns] - below[..., 2]
    seen = inside & (image.disparity[rows, columns] > 0) & (labels[rows, columns] != label)
    free = seen & (behind > MARGIN)
    other = seen & ~free
    return bool(np.mean(free.any(axis=1) & ~other.any(axis=1)) >= MIN_FREE)


def _is_carried(
    points: NDArray[np.float64], standing: Sequence[NDArray[np.float64]], plane: SupportPlane
) -> bool:
    """Return whether another region reaches up to points (N, 3), and below them.

    `standing` holds the points (M, 3) of each region that does not hang in the air, m.
    """
    bottom = quantile(plane.height(points), LOW_QUANTILE)
    for other in standing:
        heights = plane.height(other)
        if len(other) and quantile(heights, LOW_QUANTILE) > MAX_FOOT:
            continue
        high = other[heights > bottom - MAX_DISTANCE]
        gaps = points[:, None] - high[None]
        gaps -= (gaps @ plane.normal)[..., None] * plane.normal
        if len(high) and (np.einsum("ijk,ijk->ij", gaps, gaps) < MAX_DISTANCE**2).any():
            return True
    return False

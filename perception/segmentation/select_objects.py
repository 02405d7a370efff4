"""Select the regions that can be lifted: those that stand on a support and have a liftable size."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import ndimage

from .above_support import OVERHANG
from .regions import HIGH_QUANTILE, LOW_QUANTILE, MAX_REGIONS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_extent import Support
    from .working_image import WorkingImage

HULL_MARGIN = 0.012
"""Maximum distance of an object's foot outside the support's hull, m."""
WALL_MARGIN = 0.01
"""Minimum distance of an object's foot inside the hull of a container's floor, m. Walls stand at
its hull."""
FOOT_SHARE = 0.15
"""Share of a region's height that is its foot, from below."""
MIN_FOOT = 0.01
"""Minimum height of a foot, m."""
MIN_FOOT_INSIDE = 0.5
"""Minimum share of an object's foot over the hull."""
MAX_CUT_LENGTH = 0.15
"""Maximum length at which the image border cuts an object off, m. A wall or a robot is longer."""
BORDER = 2
"""Distance from the border of the image at which it cuts objects off, px."""
SAMPLES = 300
"""Pixels of a region from which its foot and extent are computed."""
FOOT_SAMPLES = 60
"""Pixels of a foot whose positions are compared with the hull."""


class _Region(NamedTuple):
    """Samples of one region."""

    points: NDArray[np.float64]
    """(N, 3), m, camera frame."""
    cut_points: NDArray[np.float64]
    """(M, 3) those at the border of the image, m."""


def select_objects(
    labels: NDArray[np.int32],
    image: WorkingImage,
    supports: list[Support],
    min_size: int,
    max_extent: float,
    *,
    enclosed: bool = False,
) -> NDArray[np.int32]:
    """Number the regions by size and drop those that cannot be objects.

    Parameters
    ----------
    labels
        Regions (H, W), 0 = none.
    image
        Their image. It is larger than the regions except at the border of the whole image.
    supports
        The foot of an object stands over the hull of one of them. Without any, only sizes count.
    min_size
        Minimum size of a region, px.
    max_extent
        Maximum diagonal of a region's bounding box, m.
    enclosed
        Whether the first support is the floor of a container. Its walls stand at its hull.

    Returns
    -------
    NDArray
        (H, W) int32: 1..n = kept regions, largest first. Only the ``MAX_REGIONS`` largest ones are
        checked. Smaller ones are kept.
    """
    sizes = np.bincount(labels.ravel(), minlength=1)
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    order = order[sizes[order] >= min_size]
    boxes = ndimage.find_objects(labels)
    renumber = np.zeros(len(sizes), np.int32)
    following = 1
    for rank, label in enumerate(order):
        if rank < MAX_REGIONS:
            region = _sample(labels[boxes[label - 1]] == label, boxes[label - 1], image)
            if not _is_object(region, supports, max_extent, enclosed=enclosed):
                continue
        renumber[label] = following
        following += 1
    return np.take(renumber, labels)


def _sample(mask: NDArray[np.bool_], box: tuple[slice, slice], image: WorkingImage) -> _Region:
    rows, columns = np.nonzero(mask & (image.depth[box] > 0))
    rows, columns = rows + box[0].start, columns + box[1].start
    height, width = image.depth.shape
    cut = (rows < BORDER) | (columns < BORDER)
    cut |= (rows >= height - BORDER) | (columns >= width - BORDER)
    step = max(rows.size // SAMPLES, 1)
    return _Region(
        image.points(rows[::step], columns[::step]), image.points(rows[cut], columns[cut])
    )


def _is_object(
    region: _Region, supports: list[Support], max_extent: float, *, enclosed: bool
) -> bool:
    points, cut_points = region
    if not len(points):
        return False
    low, high = _range(points)
    if np.linalg.norm(high - low) > max_extent:
        return False
    if not supports:
        return True
    if len(cut_points) and np.linalg.norm(np.ptp(cut_points, axis=0)) > MAX_CUT_LENGTH:
        return False
    for number, support in enumerate(supports):
        heights = support.plane.height(points)
        bottom, top = _range(heights)
        foot = points[heights <= bottom + max(FOOT_SHARE * (top - bottom), MIN_FOOT)]
        foot = foot[:: max(len(foot) // FOOT_SAMPLES, 1)] @ support.axes.T
        # An object that the image cuts off may stand on a part of the support outside the image.
        margin = -OVERHANG if len(cut_points) else -HULL_MARGIN
        if enclosed and number == 0:
            margin = WALL_MARGIN
        if np.mean(_depth_in_hull(foot, support.hull) > margin) >= MIN_FOOT_INSIDE:
            return True
    return False


def _range(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the low and high quantile along the first axis. Sorting is faster than a quantile."""
    last = len(values) - 1
    return np.sort(values, axis=0)[[round(LOW_QUANTILE * last), round(HIGH_QUANTILE * last)]]


def _depth_in_hull(points: NDArray[np.float64], hull: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the distances (N,) of points (N, 2) from the sides of a convex hull, > 0 inside."""
    sides = np.roll(hull, -1, axis=0) - hull
    inwards = np.column_stack([-sides[:, 1], sides[:, 0]]).astype(np.float64)
    inwards /= np.maximum(np.linalg.norm(inwards, axis=1), 1e-9)[:, None]
    offsets = np.einsum("ij,ij->i", inwards, hull)
    if np.sum(inwards @ hull.mean(axis=0) - offsets) < 0:
        inwards, offsets = -inwards, -offsets
    return (points @ inwards.T - offsets).min(axis=1)

"""Select the regions that can be objects on a support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy import ndimage

from .above_support import OVERHANG
from .regions import HIGH_QUANTILE, LOW_QUANTILE, MAX_REGIONS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .support_plane import Support
    from .working_image import WorkingImage

HULL_MARGIN = 0.01
"""Maximum distance of an object's centre outside the support's hull, m."""
CENTRE_PIXELS = 400
"""Pixels of a region from which its centre and extent are computed."""


def supported_regions(
    labels: NDArray[np.int32],
    image: WorkingImage,
    supports: list[Support],
    min_size: int,
    max_extent: float,
) -> NDArray[np.int32]:
    """Number the regions by size and drop those that cannot be objects.

    Parameters
    ----------
    labels
        Regions (H, W), 0 = none.
    image
        Their image.
    supports
        The centre of an object is over the hull of one of them. Without any this is not checked.
    min_size
        Minimum size of a region, px.
    max_extent
        Maximum diagonal of a region's bounding box, m.

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
            mask = labels[boxes[label - 1]] == label
            if not _is_supported(mask, boxes[label - 1], image, supports, max_extent):
                continue
        renumber[label] = following
        following += 1
    return np.take(renumber, labels)


def _is_supported(
    mask: NDArray[np.bool_],
    box: tuple[slice, slice],
    image: WorkingImage,
    supports: list[Support],
    max_extent: float,
) -> bool:
    rows, columns = np.nonzero(mask)
    step = max(rows.size // CENTRE_PIXELS, 1)
    rows, columns = rows[::step] + box[0].start, columns[::step] + box[1].start
    k = image.intrinsics
    z = image.depth[rows, columns].astype(np.float64)
    points = np.column_stack([(columns - k.cx) / k.fx * z, (rows - k.cy) / k.fy * z, z])
    extent = np.quantile(points, HIGH_QUANTILE, axis=0) - np.quantile(points, LOW_QUANTILE, axis=0)
    if np.linalg.norm(extent) > max_extent:
        return False
    # An object that the image's border cuts off may stand on a part of the support outside it.
    height, width = image.depth.shape
    cut = (
        rows.min() == 0
        or columns.min() == 0
        or rows.max() >= height - step
        or columns.max() >= width - step
    )
    margin = OVERHANG if cut else HULL_MARGIN
    for support in supports:
        centre = np.median(points @ support.axes.T, axis=0)
        inside = cv2.pointPolygonTest(support.hull, (float(centre[0]), float(centre[1])), True)
        if inside > -margin:
            return True
    return not supports

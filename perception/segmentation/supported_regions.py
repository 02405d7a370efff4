"""Which regions can be objects that stand on a support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy import ndimage

from .regions import MAX_REGIONS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .options import SegmentationOptions
    from .support_plane import Support

MIDDLE_PIXELS = 400
"""Pixels that stand for an object when its middle and its extent are looked for."""
LOW, HIGH = 0.02, 0.98
"""Quantiles of a region's points between which its extent is measured: outliers are no size."""


def standing_regions(
    labels: NDArray[np.int32],
    depth: NDArray[np.float32],
    camera: CameraIntrinsics,
    supports: list[Support],
    min_size: int,
    options: SegmentationOptions,
) -> NDArray[np.int32]:
    """Number regions (H, W) by size, without what is too small, too large or stands elsewhere.

    Small is below `min_size` px, large above ``max_extent``; with supports a region's middle
    must lie over the hull of one of them.
    """
    sizes = np.bincount(labels.ravel(), minlength=1)
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    order = order[sizes[order] >= min_size]
    boxes = ndimage.find_objects(labels)
    renumber = np.zeros(len(sizes), np.int32)
    following = 1
    for place, label in enumerate(order):
        # In clutter of thousands of pieces only the large ones are worth a closer look.
        if place < MAX_REGIONS and not _stands(
            labels, int(label), boxes[label - 1], depth, camera, supports, options
        ):
            continue
        renumber[label] = following
        following += 1
    return np.take(renumber, labels)


def _stands(
    labels: NDArray[np.int32],
    label: int,
    box: tuple[slice, slice],
    depth: NDArray[np.float32],
    camera: CameraIntrinsics,
    supports: list[Support],
    options: SegmentationOptions,
) -> bool:
    rows, columns = np.nonzero(labels[box] == label)
    step = max(rows.size // MIDDLE_PIXELS, 1)
    rows, columns = rows[::step] + box[0].start, columns[::step] + box[1].start
    z = depth[rows, columns].astype(np.float64)
    points = np.column_stack(
        [(columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z, z]
    )
    extent = np.quantile(points, HIGH, axis=0) - np.quantile(points, LOW, axis=0)
    if np.linalg.norm(extent) > options.max_extent:
        return False
    # What the image's border cuts off stands on a part of the support that was not seen either.
    cut = (
        rows.min() == 0
        or columns.min() == 0
        or rows.max() >= labels.shape[0] - step
        or columns.max() >= labels.shape[1] - step
    )
    margin = options.overhang if cut else options.hull_margin
    for support in supports:
        middle = np.median(points @ support.axes.T, axis=0)
        inside = cv2.pointPolygonTest(support.hull, (float(middle[0]), float(middle[1])), True)
        if inside > -margin:
            return True
    return not supports

"""Remove regions that are parts of a person, a robot or furniture that the image cuts off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .label_pixels import count_labels, renumber_labels
from .local_planes import LocalPlanes
from .median import median
from .regions import count_border_pairs
from .walls import MAD_TO_SIGMA, MAX_RESIDUAL
from .working_image import WorkingImage

MIN_CONTACT = 0.02
"""Minimum share of a region's border in contact with the surroundings. Objects beside a wall have a
depth step to it, and a share of at most 0.02."""
MIN_BESIDE = 0.1
"""Minimum share of its border beside the surroundings, with or without a depth step."""
MAX_OBJECT_CONTACT = 0.05
"""Maximum share of its border in contact with other regions. Parts of objects in a heap touch each
other."""
MAX_SIZE = 2000
"""Maximum size of a part, px at the reference width. A larger region may be an object that leans on
a wall, unless it is a piece of a wall."""
MIN_CUT_LENGTH = 0.075
"""Minimum length at which the image cuts off a larger part, m. It is half of
``select_objects.MAX_CUT_LENGTH``: a part of a robot close to this limit is no object in one image
and an object in the next one, unless what it touches decides."""
MIN_EXTENT = 0.4
"""Minimum diagonal of the bounding box of a piece of a wall, m. It is also flat."""
SAMPLES = 400
"""Readings of a region whose flatness is measured."""
BORDER = 2
"""Distance from the border of the image at which it cuts a region off, px."""


def remove_attached(
    kept: NDArray[np.int32],
    regions: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
) -> NDArray[np.int32]:
    """Remove the regions that belong to the surroundings, and number the others in their order.

    The surroundings are the regions at the border of the image that are no objects: a robot, a
    person, a wall. Their parts stand apart from them in the graph of patches, but touch them. Small
    parts are removed, and those of any size that are a large flat face or that the image cuts off
    too.

    Parameters
    ----------
    kept
        The regions that may be objects, 1..n (H, W).
    regions
        All regions (H, W), 0 = none.
    image
        Their image. It is larger than the regions except at the border of the whole image.
    planes
        Its local planes.
    """
    rim = (regions[:BORDER], regions[-BORDER:], regions[:, :BORDER], regions[:, -BORDER:])
    at_border = np.zeros(int(regions.max(initial=0)) + 1, np.bool_)
    at_border[np.concatenate([edge.ravel() for edge in rim])] = True
    at_border[0] = False
    if not at_border.any():
        return kept
    outer = at_border[regions] & (kept == 0)
    if not outer.any():
        return kept
    count = int(kept.max(initial=0))
    borders = count_border_pairs(np.where(outer, count + 1, kept).astype(np.int32), image, planes)
    sizes, max_size = count_labels(kept, count), image.area(MAX_SIZE)
    stays = np.ones(count + 1, np.bool_)
    stays[0] = False
    for label in range(1, count + 1):
        contact = borders.contact[label].sum(axis=1)
        steps = (
            borders.occluding[label, count + 1].sum() + borders.occluding[count + 1, label].sum()
        )
        length = max(borders.perimeter(label), 1)
        touching = contact[count + 1] / length
        attached = touching >= MIN_CONTACT and touching + steps / length >= MIN_BESIDE
        if not attached or contact[1 : count + 1].sum() > MAX_OBJECT_CONTACT * length:
            continue
        mask = kept == label
        stays[label] = sizes[label] > max_size and not (
            _cut_length(mask, image) >= MIN_CUT_LENGTH or _is_flat_and_large(mask, image)
        )
    if stays[1:].all():
        return kept
    return renumber_labels(kept, np.where(stays, np.cumsum(stays), 0).astype(np.int32))


def _cut_length(mask: NDArray[np.bool_], image: WorkingImage) -> float:
    """Return the length over which the border of the image cuts a region (H, W) off, m."""
    at_border = mask & (image.disparity > 0)
    at_border[BORDER:-BORDER, BORDER:-BORDER] = False
    points = image.points(*np.nonzero(at_border))
    return float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0


def _is_flat_and_large(mask: NDArray[np.bool_], image: WorkingImage) -> bool:
    """Return whether a region (H, W) is a flat face that is larger than an object."""
    rows, columns = np.nonzero(mask & (image.disparity > 0))
    step = max(len(rows) // SAMPLES, 1)
    points = image.points(rows[::step], columns[::step])
    if np.linalg.norm(np.ptp(points, axis=0)) < MIN_EXTENT:
        return False
    centred = points - points.mean(axis=0)
    normal = np.linalg.eigh(centred.T @ centred)[1][:, 0]
    return MAD_TO_SIGMA * median(np.abs(centred @ normal)) <= MAX_RESIDUAL

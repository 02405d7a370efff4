"""Join pieces that nothing supports to the region that they hang on, such as handles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .label_pixels import pixels_by_label
from .local_planes import LocalPlanes
from .median import quantile
from .regions import (
    ABOVE,
    BELOW,
    HIGH_QUANTILE,
    LEFT,
    LOW_QUANTILE,
    MIN_BORDER,
    RIGHT,
    Borders,
    count_border_pairs,
    merge_regions,
)
from .result import SupportPlane
from .working_image import WorkingImage

MIN_FREE_SHARE = 0.8
"""Minimum share of a hanging piece's lower edge with free space below it. A lower value joins what
stands behind a low object, a higher one leaves handles separate."""
MAX_AREA = 0.003
"""Maximum visible area of a hanging piece, m²: the area of a handle or a knob."""
MAX_SIZE_SHARE = 0.5
"""Maximum size of a hanging piece, as a share of the region that it hangs on."""
MIN_CLEARANCE = 0.4
"""Minimum height of a hanging piece above the support, as a share of its own height. A ball seen
from 60° above begins at a third, because its belly hides its foot."""


def join_floating(
    labels: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    support: SupportPlane,
) -> NDArray[np.int32]:
    """Join hanging pieces to the region that they touch most, and number the regions by size.

    A piece is supported where its lower edge touches the support or another region. It may be
    supported where something nearer hides that edge, or where a reading is missing. A piece
    hangs where most of its lower edge is a depth step to something behind it.

    Parameters
    ----------
    labels
        Regions 1..n by size, (H, W).
    image
        Their image.
    planes
        Its local planes.
    support
        The support plane, camera frame.
    """
    borders = count_border_pairs(labels, image, planes)
    count = borders.contact.shape[0] - 1
    order, starts = pixels_by_label(labels, count)
    sizes = np.diff(starts)
    parent = np.arange(count + 1, dtype=np.int32)
    down = downwards(support)
    # A handle hangs on a pot, and never the other way round, so the smallest piece comes first.
    for label in range(count, 0, -1):
        if _free_share(label, down, borders) < MIN_FREE_SHARE:
            continue
        touching = borders.contact[label].sum(axis=1)
        touching[0] = 0
        partner = int(np.argmax(touching))
        if sizes[label] > MAX_SIZE_SHARE * sizes[partner]:
            continue
        area, low, high = _measure(order[starts[label] : starts[label + 1]], image, support)
        if area > MAX_AREA or low < MIN_CLEARANCE * (high - low):
            continue
        if touching[partner] >= image.length(MIN_BORDER):
            parent[label] = partner
    for label in range(1, count + 1):
        parent[label] = _root(parent, label)
    return merge_regions(labels, parent)


def downwards(support: SupportPlane) -> int:
    """Return the image direction nearest to gravity: `RIGHT`, `LEFT`, `BELOW` or `ABOVE`."""
    x, y = -support.normal[0], -support.normal[1]
    if abs(x) > abs(y):
        return RIGHT if x > 0 else LEFT
    return BELOW if y >= 0 else ABOVE


def _free_share(label: int, down: int, borders: Borders) -> float:
    """Return the share of a region's lower edge with free space below it."""
    contact = borders.contact[label, :, down].sum()
    free = borders.occluding[label, :, down].sum()
    up = (LEFT, RIGHT, ABOVE, BELOW)[down]
    hidden = borders.occluding[:, label, up].sum() + borders.blind[label, down]
    return float(free / max(contact + free + hidden, 1))


def _measure(
    pixels: NDArray[np.integer], image: WorkingImage, support: SupportPlane
) -> tuple[float, float, float]:
    """Return a region's area as if it faced the camera, m², and its lowest and highest point, m."""
    pixels = pixels[image.disparity.flat[pixels] > 0]
    if pixels.size == 0:
        return 0.0, 0.0, 0.0
    points = image.points(*np.divmod(pixels, image.disparity.shape[1]))
    heights = support.height(points)
    low, high = quantile(heights, LOW_QUANTILE), quantile(heights, HIGH_QUANTILE)
    k = image.intrinsics
    return float((points[:, 2] ** 2).sum()) / (k.fx * k.fy), float(low), float(high)


def _root(parent: NDArray[np.int32], label: int) -> int:
    """Follow parents to the last one; the smallest label where they form a cycle."""
    visited = {label}
    while parent[label] != label:
        label = int(parent[label])
        if label in visited:
            return min(visited)
        visited.add(label)
    return label

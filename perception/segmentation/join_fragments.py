"""Join fragments too small to be objects to the large region that they touch."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .label_pixels import count_labels
from .local_planes import LocalPlanes
from .regions import count_border_pairs, relabel_by_size
from .working_image import WorkingImage

MAX_FRAGMENT = 600
"""Regions below this size are fragments if they touch a far larger one, px at the reference
width."""
MIN_BORDER_SHARE = 0.3
"""Minimum share of a fragment's outline that touches the region that it joins."""
MAX_SIZE_SHARE = 0.15
"""Maximum size of a fragment, as a share of that region. With 0.12 blotches without readings cut
parts off a ball."""


def join_fragments(
    labels: NDArray[np.int32],
    pieces: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    min_object: int,
) -> NDArray[np.int32]:
    """Join fragments to a far larger region along much of their border.

    Parameters
    ----------
    labels
        Regions (H, W), 0 = none.
    pieces
        Further regions (H, W) where `labels` is 0, too small to be objects.
    image
        Image of both.
    planes
        Its local planes.
    min_object
        Minimum size of an object, px.

    Returns
    -------
    NDArray
        (H, W) int32: the regions of at least `min_object` px 1..n, largest first.
    """
    small = (labels == 0) & (pieces > 0)
    regions = relabel_by_size(np.where(small, pieces + labels.max(initial=0), labels))
    borders = count_border_pairs(regions, image, planes)
    sizes = count_labels(regions, int(regions.max(initial=0)))
    parent = np.arange(len(sizes), dtype=np.int32)
    for label in range(len(sizes) - 1, 0, -1):
        if sizes[label] >= image.area(MAX_FRAGMENT):
            continue
        # A surface far behind an edge is another object, even if only a little of it is visible.
        touching = borders.not_behind[label].copy()
        touching[0] = 0
        partner = int(np.argmax(touching))
        if touching[partner] < MIN_BORDER_SHARE * borders.perimeter(label):
            continue
        if sizes[label] <= MAX_SIZE_SHARE * sizes[partner]:
            parent[label] = partner
    for label in range(1, len(sizes)):
        # A fragment's partner is larger, so the parent of the partner is already final.
        parent[label] = parent[parent[label]]
    return relabel_by_size(parent[regions], min_object)

"""Fragments too small to be an object of their own go to the large one that they touch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .regions import region_borders

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .options import SegmentationOptions


def join_fragments(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    options: SegmentationOptions,
) -> NDArray[np.int32]:
    """Join regions (H, W) below ``fragment`` px to a far larger one along much of their border."""
    borders = region_borders(labels, disparity, planes, options)
    sizes = np.bincount(labels.ravel(), minlength=1)
    parent = np.arange(len(sizes), dtype=np.int32)
    for label in range(len(sizes) - 1, 0, -1):
        if sizes[label] >= options.fragment:
            continue
        # What shows far behind an edge is another object, however little of it is seen.
        touching = borders.close[label].copy()
        touching[0] = 0
        partner = int(np.argmax(touching))
        if touching[partner] < options.fragment_border * borders.perimeter(label):
            continue
        if sizes[label] <= options.fragment_share * sizes[partner]:
            parent[label] = partner
    for label in range(1, len(sizes)):
        # A fragment's partner is larger, so its own partner is already settled.
        parent[label] = parent[parent[label]]
    return parent[labels]

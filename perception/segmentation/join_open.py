"""The inside of a vessel belongs to its outside: bowls, mugs, pots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from .convexity import region_turns
from .regions import Borders, fill_holes, region_borders

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..frame import CameraIntrinsics
    from .local_planes import LocalPlanes
    from .options import SegmentationOptions

RING = 2
"""Width of the strip around a vessel's mouth in which its outside is looked for, px."""


def join_open(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    camera: CameraIntrinsics,
    options: SegmentationOptions,
) -> NDArray[np.int32]:
    """Join hollow regions (H, W) to the region before them, and give them their floor.

    Only the inside of something curves towards the viewer, and the near wall of the vessel hides
    its lower edge. A region whose normals converge, and of whose outline (with the floor, which
    may be too close to the table to stand out) a good part lies behind or against another
    region, is that region's inside.
    """
    borders = region_borders(labels, disparity, planes, options)
    sizes = np.bincount(labels.ravel())
    turns = region_turns(labels, disparity, planes, camera)
    hollow = [
        label
        for label in range(1, borders.contact.shape[0])
        if sizes[label] >= options.min_hollow
        and turns[label] < -options.hollow_turn
        and _neighbour_share(label, borders) > 0
    ]
    if not hollow:
        return labels
    joined = labels.copy()
    floors = _enclosed(labels, disparity)
    for label in hollow:
        inside = labels == label
        mouth = inside | _floor(inside, floors, options)
        # The wall of a vessel lies before its inside or touches it; what lies behind is no wall.
        nearer = borders.before[:, label].sum(axis=1) + borders.contact[:, label].sum(axis=1)
        walls = np.where(nearer[labels] >= options.min_border, joined, 0)
        outside = _outside(_convex(mouth), walls, disparity, options)
        if outside == 0:
            continue
        joined[mouth] = outside
        whole = joined == outside
        joined[fill_holes(whole) & (joined == 0) & (disparity > 0)] = outside
    return joined


def _neighbour_share(label: int, borders: Borders) -> float:
    touching = borders.contact[label, 1:].sum() + borders.before[1:, label].sum()
    return float(touching / max(borders.perimeter(label), 1))


def _enclosed(labels: NDArray[np.int32], disparity: NDArray[np.float32]) -> NDArray[np.int32]:
    """Connected background pixels, numbered from 1; the largest part, the table, is 0."""
    empty = ((labels == 0) & (disparity > 0)).astype(np.uint8)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(empty, connectivity=4)
    stats[0, cv2.CC_STAT_AREA] = 0
    largest = int(np.argmax(stats[:, cv2.CC_STAT_AREA]))
    return np.where(parts == largest, 0, parts).astype(np.int32)


def _floor(
    inside: NDArray[np.bool_], floors: NDArray[np.int32], options: SegmentationOptions
) -> NDArray[np.bool_]:
    """Enclosed background that borders a hollow region and is not much larger than that."""
    ring = _ring(inside, options.gap_reach // 2)
    touching = np.bincount(floors[ring], minlength=int(floors.max(initial=0)) + 1)
    touching[0] = 0
    sizes = np.bincount(floors.ravel(), minlength=touching.size)
    near = (touching > 0) & (sizes < options.max_floor * np.count_nonzero(inside))
    return near[floors]


def _convex(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Image convex hull: what lies in a vessel is not its outside."""
    outlines, _ = cv2.findContours(
        mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE
    )
    filled = np.zeros(mask.shape, np.uint8)
    cv2.fillConvexPoly(filled, cv2.convexHull(np.concatenate(outlines)), 1)
    return filled.astype(bool)


def _ring(mask: NDArray[np.bool_], width: int) -> NDArray[np.bool_]:
    kernel = np.ones((2 * width + 1, 2 * width + 1), np.uint8)
    return cv2.dilate(mask.astype(np.uint8), kernel).astype(bool) & ~mask


def _outside(
    mouth: NDArray[np.bool_],
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    options: SegmentationOptions,
) -> int:
    """Region along the largest part of the mouth's outline, 0 when that part is too small."""
    around = labels[_ring(mouth, RING) & (disparity > 0)]
    if around.size == 0:
        return 0
    counts = np.bincount(around)
    counts[0] = 0
    best = int(np.argmax(counts))
    return best if counts[best] >= options.min_rim_share * around.size else 0

"""Join the inside of a vessel to its outside: bowls, mugs, pots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np
from scipy import ndimage

from .connected_parts import connected_parts
from .convexity import HOLLOW, region_convexity
from .regions import MAX_GAP, MIN_BORDER, Borders, count_border_pairs, fill_holes, relabel_by_size

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .working_image import WorkingImage

MIN_HOLLOW = 300
"""Minimum size of the inside of a vessel, px at the reference width. Noise can make fewer pixels
hollow."""
MIN_RIM_SHARE = 0.25
"""Minimum share of a vessel's mouth along which its outside is visible. A lower value joins
neighbours."""
MAX_FLOOR = 2.0
"""Maximum size of a vessel's floor, as a multiple of the visible inside. A higher value fills wide
pots, and takes the table between objects for a floor."""
RING = 2
"""Width of the strip around a vessel's mouth in which its outside is searched, px."""


def join_open(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes
) -> NDArray[np.int32]:
    """Join hollow regions to the region in front of them, and number the regions by size.

    Only the inside of a vessel curves towards the camera, and the near wall hides its lower edge.
    The mouth is such a region together with its floor, which may be too close to the table to be
    a region. The mouth joins the region along a good part of its outline.

    Parameters
    ----------
    labels
        Regions 1..n by size, (H, W).
    image
        Their image.
    planes
        Its local planes.
    """
    borders = count_border_pairs(labels, image, planes)
    sizes = np.bincount(labels.ravel())
    convexity = region_convexity(labels, image, planes)
    hollow = [
        label
        for label in range(1, borders.contact.shape[0])
        if sizes[label] >= image.area(MIN_HOLLOW)
        and convexity[label] < HOLLOW
        and _has_neighbour(label, borders)
    ]
    if not hollow:
        return labels
    disparity = image.disparity
    joined = labels.copy()
    floors = _enclosed(labels, disparity)
    for label in hollow:
        inside = labels == label
        mouth = inside | _floor(inside, floors, image.length(MAX_GAP) // 2)
        # The wall of a vessel is in front of its inside or touches it.
        nearer = borders.occluding[:, label].sum(axis=1) + borders.contact[:, label].sum(axis=1)
        walls = np.where(nearer[labels] >= image.length(MIN_BORDER), joined, 0)
        outside = _outside(_convex_hull(mouth), walls, disparity)
        if outside == 0:
            continue
        joined[mouth] = outside
        whole = joined == outside
        joined[fill_holes(whole) & (joined == 0) & (disparity > 0)] = outside
    return relabel_by_size(joined)


def fill_mouths(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes
) -> NDArray[np.int32]:
    """Add the unlabelled readings within the image convex hull of each hollow region.

    The floor of a bowl may be too close to the table to be above it.
    """
    filled = labels.copy()
    convexity = region_convexity(labels, image, planes)
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        if box is None or convexity[label] >= HOLLOW:
            continue
        mask = labels[box] == label
        mouth = _convex_hull(mask) & (labels[box] == 0) & (image.disparity[box] > 0)
        if np.count_nonzero(mouth) <= MAX_FLOOR * np.count_nonzero(mask):
            filled[box][mouth] = label
    return filled


def _has_neighbour(label: int, borders: Borders) -> bool:
    return bool(borders.contact[label, 1:].sum() + borders.occluding[1:, label].sum() > 0)


def _enclosed(labels: NDArray[np.int32], disparity: NDArray[np.float32]) -> NDArray[np.int32]:
    """Number the connected parts of the background from 1; the largest one, the table, is 0."""
    empty = ((labels == 0) & (disparity > 0)).astype(np.uint8)
    parts, sizes, _ = connected_parts(empty)
    largest = 1 + int(np.argmax(sizes[1:])) if len(sizes) > 1 else 0
    return np.where(parts == largest, 0, parts).astype(np.int32)


def _floor(inside: NDArray[np.bool_], floors: NDArray[np.int32], reach: int) -> NDArray[np.bool_]:
    """Return the enclosed background within `reach` px of a hollow region, if small enough."""
    touching = np.bincount(floors[_ring(inside, reach)], minlength=int(floors.max(initial=0)) + 1)
    touching[0] = 0
    sizes = np.bincount(floors.ravel(), minlength=touching.size)
    near = (touching > 0) & (sizes < MAX_FLOOR * np.count_nonzero(inside))
    return near[floors]


def _convex_hull(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the image convex hull of a mask. An object in it is not the vessel's outside."""
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
    mouth: NDArray[np.bool_], labels: NDArray[np.int32], disparity: NDArray[np.float32]
) -> int:
    """Return the region along the largest part of the mouth's outline, 0 if that part is small."""
    around = labels[_ring(mouth, RING) & (disparity > 0)]
    if around.size == 0:
        return 0
    counts = np.bincount(around)
    counts[0] = 0
    best = int(np.argmax(counts))
    return best if counts[best] >= MIN_RIM_SHARE * around.size else 0

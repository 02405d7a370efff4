"""Join the inside of a vessel to its outside: bowls, mugs, pots."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from .connected_parts import ConnectedParts, connected_parts
from .convexity import HOLLOW, region_convexity
from .label_pixels import count_labels
from .local_planes import LocalPlanes
from .regions import MAX_GAP, MIN_BORDER, Borders, count_border_pairs, fill_holes, relabel_by_size
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
MIN_FLOOR_CONTACT, MAX_FLOOR_STEP = 0.4, 0.1
"""Minimum share of the border of a floor that touches the inside, and maximum share at which it
hides the inside, if the floor is a region of its own. Objects in a vessel hide what lies behind
them."""
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
    count = int(labels.max(initial=0))
    sizes, min_size = count_labels(labels, count), image.area(MIN_HOLLOW)
    curved = region_convexity(labels, image, planes) < HOLLOW
    hollow = [k for k in range(1, count + 1) if curved[k] and sizes[k] >= min_size]
    if not hollow:
        return labels
    borders = count_border_pairs(labels, image, planes)
    owner = _floor_owners(hollow, borders, sizes)
    if np.any(owner != np.arange(count + 1)):
        labels = owner[labels]
        hollow = [k for k in hollow if owner[k] == k]
        borders = count_border_pairs(labels, image, planes)
    joined = labels.copy()
    floors = _enclosed(labels, image.disparity)
    for label in hollow:
        if _has_neighbour(label, borders):
            _join_outside(label, labels, joined, floors, borders, image)
    return relabel_by_size(joined)


def _floor_owners(
    hollow: list[int], borders: Borders, sizes: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Return the hollow region that each region is the floor of, or its own number, (n + 1,)."""
    owner = np.arange(len(borders.contact), dtype=np.int32)
    for label in hollow:
        for k in range(1, len(owner)):
            if sizes[k] >= sizes[label]:
                continue
            border = borders.perimeter(k)
            touching, hiding = borders.contact[k, label].sum(), borders.occluding[k, label].sum()
            if touching >= MIN_FLOOR_CONTACT * border and hiding <= MAX_FLOOR_STEP * border:
                owner[k] = owner[label]
    return owner


def fill_mouths(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes
) -> NDArray[np.int32]:
    """Add the unlabelled readings within the image convex hull of each hollow region.

    The floor of a bowl may be too close to the table to be above it.
    """
    curved = region_convexity(labels, image, planes) < HOLLOW
    if not curved.any():
        return labels
    filled = labels.copy()
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        if box is None or not curved[label]:
            continue
        mask = labels[box] == label
        mouth = _convex_hull(mask) & (labels[box] == 0) & (image.disparity[box] > 0)
        if np.count_nonzero(mouth) <= MAX_FLOOR * np.count_nonzero(mask):
            filled[box][mouth] = label
    return filled


def _join_outside(
    label: int,
    labels: NDArray[np.int32],
    joined: NDArray[np.int32],
    floors: ConnectedParts,
    borders: Borders,
    image: WorkingImage,
) -> None:
    """Join the mouth of a hollow region to its outside in `joined`, if there is one."""
    reach = image.length(MAX_GAP) // 2
    inside_box = _widened(_box(labels == label), max(reach, RING), labels.shape)
    inside = labels[inside_box] == label
    numbers = _floor(inside, floors, inside_box, reach)
    box = inside_box
    for number in numbers:
        top, left, bottom, right = (int(edge) for edge in floors.boxes[number])
        part = _widened((slice(top, bottom), slice(left, right)), RING, labels.shape)
        box = _union(box, part)
    disparity = image.disparity[box]
    mouth = (labels[box] == label) | np.isin(floors.labels[box], numbers)
    # The wall of a vessel is in front of its inside or touches it.
    nearer = borders.occluding[:, label].sum(axis=1) + borders.contact[:, label].sum(axis=1)
    near = nearer >= image.length(MIN_BORDER)
    walls = np.where(near[labels[box]], joined[box], 0)
    outside = _outside(_convex_hull(mouth), walls, disparity)
    if outside == 0:
        return
    joined[box][mouth] = outside
    whole = joined == outside
    joined[fill_holes(whole) & (joined == 0) & (image.disparity > 0)] = outside


def _box(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and columns of the bounding box of a mask that is not empty."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    return slice(top, top + height), slice(left, left + width)


def _widened(box: tuple[slice, slice], margin: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return a box widened on all sides, but not beyond an image of this shape."""
    rows, columns = box
    return (
        slice(max(rows.start - margin, 0), min(rows.stop + margin, shape[0])),
        slice(max(columns.start - margin, 0), min(columns.stop + margin, shape[1])),
    )


def _union(a: tuple[slice, slice], b: tuple[slice, slice]) -> tuple[slice, slice]:
    """Return the smallest box around two boxes."""
    return (
        slice(min(a[0].start, b[0].start), max(a[0].stop, b[0].stop)),
        slice(min(a[1].start, b[1].start), max(a[1].stop, b[1].stop)),
    )


def _has_neighbour(label: int, borders: Borders) -> bool:
    return bool(borders.contact[label, 1:].sum() + borders.occluding[1:, label].sum() > 0)


def _enclosed(labels: NDArray[np.int32], disparity: NDArray[np.float32]) -> ConnectedParts:
    """Return the connected parts of the background; the largest one, the table, has no size."""
    parts = connected_parts(((labels == 0) & (disparity > 0)).view(np.uint8))
    parts.sizes[0] = 0
    parts.sizes[np.argmax(parts.sizes)] = 0
    return parts


def _floor(
    inside: NDArray[np.bool_], floors: ConnectedParts, box: tuple[slice, slice], reach: int
) -> list[int]:
    """Return the enclosed background within `reach` px of a hollow region, if small enough.

    `inside` is the mask of the region in a box that is wider by `reach` px.
    """
    near = np.unique(floors.labels[box][_ring(inside, reach)])
    max_size = MAX_FLOOR * np.count_nonzero(inside)
    return [int(part) for part in near if 0 < floors.sizes[part] < max_size]


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

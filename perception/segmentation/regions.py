"""Regions of a label image: relabel them by size, and count the pixel pairs on their borders."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import count_labels, renumber_labels
from .local_planes import CREASE_SIGMAS, STEP_SIGMAS, LocalPlanes
from .working_image import WorkingImage

MAX_REGIONS = 200
"""Maximum number of regions. Only the largest ones are kept. It bounds time and memory in
clutter."""
MIN_BORDER = 8
"""Minimum length of the border of two regions that can be joined, pixel pairs at
``working_image.REFERENCE_WIDTH``."""
MAX_GAP = 16
"""Maximum width of a strip without readings between two neighbouring regions, px at
``working_image.REFERENCE_WIDTH``. A projector or a second lens leaves such a shadow beside an
object."""
CLOSE_GAP = 0.02
"""Maximum depth step from a small piece to the object it belongs to, m."""
LOW_QUANTILE, HIGH_QUANTILE = 0.02, 0.98
"""Quantiles of a region's points between which its extent is measured. They exclude outliers."""
RIGHT, LEFT, BELOW, ABOVE = range(4)
"""Position in the image of the second region of a border, relative to the first one."""


class Borders(NamedTuple):
    """Counts of border pixel pairs between the regions 0..n (0 = background).

    The last axis of length 4 is the direction from the first region to the second one: ``RIGHT``,
    ``LEFT``, ``BELOW`` or ``ABOVE``.
    """

    contact: NDArray[np.int32]
    """(n+1, n+1, 4): pairs without a depth step. A pair without a local plane counts as a step."""
    occluding: NDArray[np.int32]
    """(n+1, n+1, 4): pairs with a depth step at which the first region is nearer."""
    not_behind: NDArray[np.int32]
    """(n+1, n+1): pairs at which the first region is at most ``CLOSE_GAP`` behind the second."""
    blind: NDArray[np.int32]
    """(n+1, 4): border pixels at the image edge, or without a reading within ``MAX_GAP`` beyond
    them."""

    def perimeter(self, label: int) -> int:
        """Return the length of a region's border: its pixel pairs and its blind pixels."""
        steps = self.occluding[label].sum() + self.occluding[:, label].sum()
        return int(self.contact[label].sum() + steps + self.blind[label].sum())


def count_border_pairs(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes
) -> Borders:
    """Count the border pixel pairs of all pairs of regions 0..n of labels (H, W), 0 = background.

    Two pixels are a pair if they are neighbours in a row or column. They are also a pair if at
    most ``MAX_GAP`` missing readings, and nothing else, lie between them.
    """
    return Borders(
        *border_counts(
            labels,
            image.disparity,
            planes,
            int(labels.max(initial=0)),
            np.float32(STEP_SIGMAS * image.noise),
            np.float32(CREASE_SIGMAS * image.noise),
            image.length(MAX_GAP),
        )
    )


def relabel_by_size(labels: NDArray[np.int32], min_size: int = 1) -> NDArray[np.int32]:
    """Relabel the regions to 1..n, largest first.

    Regions below `min_size` px become 0, and so do all but the ``MAX_REGIONS`` largest ones.
    """
    sizes = count_labels(labels, int(labels.max(initial=0)))
    return renumber_labels(labels, _labels_by_size(sizes, min_size))


def merge_regions(labels: NDArray[np.int32], parent: NDArray[np.int32]) -> NDArray[np.int32]:
    """Merge each region k with ``parent[k]``, (n + 1,), and relabel all regions by size.

    The parent of a parent is itself. If no region is merged, `labels` is returned unchanged.
    """
    if np.array_equal(parent, np.arange(len(parent))):
        return labels
    sizes = count_labels(labels, len(parent) - 1)
    merged = np.bincount(parent, weights=sizes, minlength=len(parent)).astype(np.int64)
    return renumber_labels(labels, _labels_by_size(merged, 1)[parent])


def relabel_with_reasons(
    labels: NDArray[np.int32], reasons: dict[int, str]
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Relabel the regions by size, largest first, and change the keys of `reasons` with them.

    `reasons` maps a label to the reason why its region is ambiguous. Labels without pixels are
    removed. The keys of the result are sorted.
    """
    sizes = count_labels(labels, int(labels.max(initial=0)))
    new_labels = _labels_by_size(sizes, 1)
    new_reasons = {
        int(new_labels[label]): reason
        for label, reason in reasons.items()
        if label < len(sizes) and sizes[label]
    }
    return renumber_labels(labels, new_labels), dict(sorted(new_reasons.items()))


def _labels_by_size(sizes: NDArray[np.integer], min_size: int) -> NDArray[np.int32]:
    """Return the new label of each old label from the sizes of all labels, (n + 1,)."""
    sizes = sizes.copy()
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")[:MAX_REGIONS]
    order = order[sizes[order] >= min_size]
    labels = np.zeros(len(sizes), np.int32)
    labels[order] = np.arange(1, len(order) + 1, dtype=np.int32)
    return labels


def fill_holes(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fill the holes of a mask (H, W): set all pixels inside its outer outlines."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return filled.astype(bool)


@njit(cache=True, nogil=True)
def border_counts(labels, q, planes, count, max_step, max_crease, max_gap):
    """Count the border pixel pairs of all regions; return the fields of `Borders`.

    A pair has a step if the plane of each pixel misses the reading of the other one. The two
    errors are added. At a crease without a step their sum is the change of slope, so this change
    is subtracted up to `max_crease`.

    Parameters
    ----------
    labels, q
        Labels 0..`count` and disparity, 1/m, both (H, W).
    planes
        Local planes of the image.
    max_step, max_crease
        Maximum step and maximum change of slope of a pair in contact, 1/m.
    max_gap
        Maximum number of missing readings between the pixels of a pair.
    """
    rows, columns = labels.shape
    contact = np.zeros((count + 1, count + 1, 4), np.int32)
    occluding = np.zeros((count + 1, count + 1, 4), np.int32)
    not_behind = np.zeros((count + 1, count + 1), np.int32)
    blind = np.zeros((count + 1, 4), np.int32)
    counts = contact, occluding, not_behind
    none = -max_gap - 2
    # The last reading of each column, and the last one of the present row.
    above = np.full(columns, none)
    inner = np.zeros(columns, np.bool_)
    for v in range(rows):
        left = none
        _mark_inner(labels, q, v, inner)
        for u in range(columns):
            if inner[u]:
                left, above[u] = u, v
                continue
            if q[v, u] <= 0:
                continue
            b = labels[v, u]
            gap = u - left
            if gap > max_gap + 1:
                blind[b, LEFT] += 1
                if left >= 0:
                    blind[labels[v, left], RIGHT] += 1
            elif labels[v, left] != b:
                pair = (v, left), (v, u)
                _count_pair(labels, q, planes, pair, (max_step, max_crease), counts)
            left = u
            gap = v - above[u]
            if gap > max_gap + 1:
                blind[b, ABOVE] += 1
                if above[u] >= 0:
                    blind[labels[above[u], u], BELOW] += 1
            elif labels[above[u], u] != b:
                pair = (above[u], u), (v, u)
                _count_pair(labels, q, planes, pair, (max_step, max_crease), counts)
            above[u] = v
        if left >= 0:
            blind[labels[v, left], RIGHT] += 1
    for u in range(columns):
        if above[u] >= 0:
            blind[labels[above[u], u], BELOW] += 1
    return contact, occluding, not_behind, blind


@njit(cache=True, nogil=True)
def _mark_inner(labels, q, v, inner):
    """Mark the readings of row v with a reading of the same label to the left and above, (W,).

    The compiler handles several pixels of this loop at once.
    """
    here, above, at, over = labels[v], labels[max(v - 1, 0)], q[v], q[max(v - 1, 0)]
    for u in range(1, len(here)):
        same = (here[u] == here[u - 1]) & (here[u] == above[u])
        inner[u] = same & (at[u] > 0) & (at[u - 1] > 0) & (over[u] > 0) & (v > 0)


@njit(cache=True, nogil=True)
def _count_pair(labels, q, planes, pair, limits, counts):
    """Count one pair of border pixels of the same row or column, the left or upper one first."""
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    max_step, max_crease = limits
    contact, occluding, not_behind = counts
    (pv, pu), (v, u) = pair
    a, b = labels[pv, pu], labels[v, u]
    depth_step = 1.0 / q[v, u] - 1.0 / q[pv, pu]
    if depth_step >= -CLOSE_GAP:
        not_behind[a, b] += 1
    if depth_step <= CLOSE_GAP:
        not_behind[b, a] += 1
    rise = q[v, u] - q[pv, pu]
    if v == pv:
        ahead, back = RIGHT, LEFT
        error_a = rise - slope_u[pv, pu] * (u - pu)
        error_b = rise - slope_u[v, u] * (u - pu)
    else:
        ahead, back = BELOW, ABOVE
        error_a = rise - slope_v[pv, pu] * (v - pv)
        error_b = rise - slope_v[v, u] * (v - pv)
    step = abs(error_a) + abs(error_b) - min(abs(error_b - error_a), max_crease)
    if value[v, u] > 0 and value[pv, pu] > 0 and step < max_step:
        contact[a, b, ahead] += 1
        contact[b, a, back] += 1
    elif rise < 0:
        occluding[a, b, ahead] += 1
    else:
        occluding[b, a, back] += 1

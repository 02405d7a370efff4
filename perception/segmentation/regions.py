"""Regions of a label image: their numbers, and the borders between them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from .local_planes import CREASE_SIGMAS, STEP_SIGMAS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .working_image import WorkingImage

MAX_REGIONS = 200
"""Maximum number of regions, the largest first. It bounds time and memory in clutter."""
MIN_BORDER = 8
"""Minimum border of two regions that can be joined, pixel pairs at the reference width."""
MAX_GAP = 16
"""Maximum width of a strip without readings between two neighbouring regions, px at the reference
width. A projector or a second lens leaves such a shadow beside an object."""
CLOSE_GAP = 0.02
"""Maximum depth step from a small piece to the object it belongs to, m."""
LOW_QUANTILE, HIGH_QUANTILE = 0.02, 0.98
"""Quantiles of a region's points between which its extent is measured. They exclude outliers."""
RIGHT, LEFT, BELOW, ABOVE = range(4)
"""Position in the image of the second region of a border, relative to the first one."""


class Borders(NamedTuple):
    """Numbers of border pixel pairs between the regions 0..n (0 = background), by direction."""

    contact: NDArray[np.int32]
    """(n+1, n+1, 4): pairs without a depth step."""
    before: NDArray[np.int32]
    """(n+1, n+1, 4): pairs with a depth step at which the first region is nearer."""
    close: NDArray[np.int32]
    """(n+1, n+1): pairs at which the first region is nearer, or behind by at most ``CLOSE_GAP``."""
    blind: NDArray[np.int32]
    """(n+1, 4): border pixels with no reading beyond them."""

    def perimeter(self, label: int) -> int:
        """Return the number of border pixel pairs of one region."""
        pairs = self.contact[label].sum() + self.before[label].sum() + self.before[:, label].sum()
        return int(pairs + self.blind[label].sum())


def region_borders(labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes) -> Borders:
    """Count the borders between the regions 1..n of labels (H, W) and the background.

    Two pixels border each other when they are neighbours in a row or column. They also do when
    only missing readings are between them, at most ``MAX_GAP``.
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


def number_by_size(labels: NDArray[np.int32], min_size: int = 1) -> NDArray[np.int32]:
    """Number the regions of at least `min_size` px 1..n, n <= MAX_REGIONS, largest first."""
    return np.take(_numbers(np.bincount(labels.ravel(), minlength=1), min_size), labels)


def merge_regions(labels: NDArray[np.int32], parent: NDArray[np.int32]) -> NDArray[np.int32]:
    """Merge each region k with ``parent[k]``, (n + 1,), and number the results by size.

    The parent of a parent is itself. Labels without a merge are returned as they are.
    """
    if np.array_equal(parent, np.arange(len(parent))):
        return labels
    sizes = np.bincount(labels.ravel(), minlength=len(parent))
    merged = np.bincount(parent, weights=sizes, minlength=len(parent)).astype(np.int64)
    return np.take(_numbers(merged, 1)[parent], labels)


def number_with_reasons(
    labels: NDArray[np.int32], reasons: dict[int, str]
) -> tuple[NDArray[np.int32], dict[int, str]]:
    """Number the regions by size, and the labels of a dictionary with them, in rising order."""
    sizes = np.bincount(labels.ravel(), minlength=1)
    numbers = _numbers(sizes, 1)
    renumbered = {
        int(numbers[label]): reason
        for label, reason in reasons.items()
        if label < len(sizes) and sizes[label]
    }
    return np.take(numbers, labels), dict(sorted(renumbered.items()))


def _numbers(sizes: NDArray[np.integer], min_size: int) -> NDArray[np.int32]:
    """Return the new number of each label from the sizes of all labels, (n + 1,)."""
    sizes = sizes.copy()
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")[:MAX_REGIONS]
    order = order[sizes[order] >= min_size]
    numbers = np.zeros(len(sizes), np.int32)
    numbers[order] = np.arange(1, len(order) + 1, dtype=np.int32)
    return numbers


def fill_holes(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask (H, W) together with everything that its outer outlines enclose."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return filled.astype(bool)


@njit(cache=True, nogil=True)
def border_counts(labels, q, planes, count, max_step, max_crease, max_gap):
    """Count the borders of all regions and return the fields of `Borders`.

    See :func:`.merge_patches.border_votes` for the test of a step.
    """
    value, slope_u, slope_v = planes.value, planes.slope_u, planes.slope_v
    rows, columns = labels.shape
    contact = np.zeros((count + 1, count + 1, 4), np.int32)
    before = np.zeros((count + 1, count + 1, 4), np.int32)
    close = np.zeros((count + 1, count + 1), np.int32)
    blind = np.zeros((count + 1, 4), np.int32)
    for axis in range(2):
        outer, inner = (rows, columns) if axis == 0 else (columns, rows)
        ahead, back = (RIGHT, LEFT) if axis == 0 else (BELOW, ABOVE)
        for i in range(outer):
            last = -max_gap - 2
            for j in range(inner):
                v, u = (i, j) if axis == 0 else (j, i)
                if q[v, u] <= 0:
                    continue
                b = labels[v, u]
                gap = j - last
                pv, pu = (i, last) if axis == 0 else (last, i)
                if gap > max_gap + 1:
                    blind[b, back] += 1
                    if last >= 0:
                        blind[labels[pv, pu], ahead] += 1
                    last = j
                    continue
                last = j
                a = labels[pv, pu]
                if a == b:
                    continue
                behind = 1.0 / q[v, u] - 1.0 / q[pv, pu]
                if behind >= -CLOSE_GAP:
                    close[a, b] += 1
                if behind <= CLOSE_GAP:
                    close[b, a] += 1
                rise = q[v, u] - q[pv, pu]
                if axis == 0:
                    near = rise - slope_u[pv, pu] * gap
                    far = rise - slope_u[v, u] * gap
                else:
                    near = rise - slope_v[pv, pu] * gap
                    far = rise - slope_v[v, u] * gap
                step = abs(near) + abs(far) - min(abs(far - near), max_crease)
                if value[v, u] > 0 and value[pv, pu] > 0 and step < max_step:
                    contact[a, b, ahead] += 1
                    contact[b, a, back] += 1
                elif rise < 0:
                    before[a, b, ahead] += 1
                else:
                    before[b, a, back] += 1
            if last >= 0:
                v, u = (i, last) if axis == 0 else (last, i)
                blind[labels[v, u], ahead] += 1
    return contact, before, close, blind

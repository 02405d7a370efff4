"""What borders what: contacts and occlusions between the regions of a label image."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .local_planes import LocalPlanes
    from .options import SegmentationOptions

MAX_REGIONS = 200
"""Regions whose borders are told apart, the largest first: bounds time and memory in clutter."""
RIGHT, LEFT, BELOW, ABOVE = range(4)
"""Where in the image the second region of a border lies, seen from the first."""


class Borders(NamedTuple):
    """Border pixel pairs between regions 0..n (0 = background), by direction."""

    contact: NDArray[np.int32]
    """(n+1, n+1, 4): pairs without a depth step."""
    before: NDArray[np.int32]
    """(n+1, n+1, 4): pairs at whose step the first region is nearer than the second."""
    close: NDArray[np.int32]
    """(n+1, n+1): pairs at which the first region is nearer, or behind by ``close_gap`` at most."""
    blind: NDArray[np.int32]
    """(n+1, 4): border pixels beyond which nothing was measured."""

    def perimeter(self, label: int) -> int:
        """Border pixel pairs of one region."""
        pairs = self.contact[label].sum() + self.before[label].sum() + self.before[:, label].sum()
        return int(pairs + self.blind[label].sum())


def region_borders(
    labels: NDArray[np.int32],
    disparity: NDArray[np.float32],
    planes: LocalPlanes,
    options: SegmentationOptions,
) -> Borders:
    """Count the borders between regions 1..n (n <= MAX_REGIONS) and the background.

    Two pixels border each other when they are neighbours in a row or column, or when nothing but
    missing readings lies between them, at most ``gap_reach`` of them: the shadow that a
    projector or a second lens leaves beside every object.
    """
    contact, before, close, blind = border_counts(
        labels,
        disparity,
        planes.value,
        planes.slope_u,
        planes.slope_v,
        int(labels.max(initial=0)),
        np.float32(options.grow_sigmas * planes.noise),
        np.float32(options.crease_sigmas * planes.noise),
        options.gap_reach,
        options.close_gap,
    )
    return Borders(contact, before, close, blind)


def largest_regions(labels: NDArray[np.int32], min_size: int) -> NDArray[np.int32]:
    """Number the regions of at least `min_size` px 1..n by size, n <= MAX_REGIONS, others 0."""
    sizes = np.bincount(labels.ravel(), minlength=1)
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")[:MAX_REGIONS]
    order = order[sizes[order] >= min_size]
    renumber = np.zeros(len(sizes), np.int32)
    renumber[order] = np.arange(1, len(order) + 1, dtype=np.int32)
    return np.take(renumber, labels)


def fill_holes(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Fill what a region's outer outlines enclose, (H, W) bool."""
    outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = np.zeros(mask.shape, np.uint8)
    cv2.drawContours(filled, outlines, -1, 1, cv2.FILLED)
    return filled.astype(bool)


@njit(cache=True, nogil=True)
def border_counts(
    labels, q, value, slope_u, slope_v, count, max_step, max_crease, gap_reach, close_gap
):
    """Borders of all regions; see :func:`region_borders`."""
    rows, columns = labels.shape
    contact = np.zeros((count + 1, count + 1, 4), np.int32)
    before = np.zeros((count + 1, count + 1, 4), np.int32)
    close = np.zeros((count + 1, count + 1), np.int32)
    blind = np.zeros((count + 1, 4), np.int32)
    for axis in range(2):
        outer, inner = (rows, columns) if axis == 0 else (columns, rows)
        ahead, back = (RIGHT, LEFT) if axis == 0 else (BELOW, ABOVE)
        for i in range(outer):
            last = -gap_reach - 2
            for j in range(inner):
                v, u = (i, j) if axis == 0 else (j, i)
                if q[v, u] <= 0:
                    continue
                b = labels[v, u]
                gap = j - last
                pv, pu = (i, last) if axis == 0 else (last, i)
                if gap > gap_reach + 1:
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
                if behind >= -close_gap:
                    close[a, b] += 1
                if behind <= close_gap:
                    close[b, a] += 1
                # On a crease the planes cross between the pixels; see `border_votes`.
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

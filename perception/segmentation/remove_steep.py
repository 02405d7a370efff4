"""Remove small regions seen at a grazing angle: readings between two surfaces, rims of walls."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import count_labels
from .local_planes import LocalPlanes
from .regions import relabel_by_size
from .working_image import WorkingImage

MAX_AREA = 700
"""Size from which a region is kept, px at the reference width."""
MIN_COSINE = 0.25
"""Minimum cosine of the angle between a surface and the view, 75°, for a reading to be reliable.
With 0.2 more ramps stay in real frames, with 0.3 more sides of hidden objects go."""
MAX_STEEP_SHARE = 0.5
"""Maximum share of unreliable readings of a small region."""


def remove_steep(
    labels: NDArray[np.int32], image: WorkingImage, planes: LocalPlanes
) -> NDArray[np.int32]:
    """Drop the small regions that are seen at a grazing angle, and number the others by size.

    At the edge of an object a sensor measures points between the object and what lies behind. They
    form a ramp almost parallel to the view. The faces of walls look the same. A real side of an
    object is rarely visible alone, and at such an angle its shape is not measured.

    Parameters
    ----------
    labels
        Regions 1..n by size, (H, W).
    image
        Their image.
    planes
        Its local planes.
    """
    sizes = count_labels(labels, int(labels.max(initial=0)))
    small = sizes < image.area(MAX_AREA)
    small[0] = False
    if not small.any():
        return labels
    known, steep = count_steep(labels, small, planes, image.pinhole, MIN_COSINE)
    dropped = steep > MAX_STEEP_SHARE * known
    return relabel_by_size(np.where(dropped[labels], 0, labels)) if dropped.any() else labels


@njit(cache=True, nogil=True)
def count_steep(labels, counted, planes, pinhole, min_cosine):
    """Return for each label the pixels with a plane, and those of a plane almost along the view.

    Only labels marked in `counted` (n + 1,) count. Both results are (n + 1,) int64.
    """
    fx, fy, cx, cy = pinhole
    known, steep = np.zeros(len(counted), np.int64), np.zeros(len(counted), np.int64)
    for v in range(labels.shape[0]):
        for u in range(labels.shape[1]):
            label, value = labels[v, u], planes.value[v, u]
            if not counted[label] or value <= 0:
                continue
            x, y = planes.slope_u[v, u] * fx, planes.slope_v[v, u] * fy
            z = value - planes.slope_u[v, u] * (u - cx) - planes.slope_v[v, u] * (v - cy)
            ray = ((u - cx) / fx) ** 2 + ((v - cy) / fy) ** 2 + 1.0
            known[label] += 1
            steep[label] += value * value < min_cosine**2 * (x * x + y * y + z * z) * ray
    return known, steep

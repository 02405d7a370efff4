"""Remove small regions seen at a grazing angle: readings between two surfaces, rims of walls."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .label_pixels import count_labels
from .local_planes import LocalPlanes
from .regions import HIGH_QUANTILE, LOW_QUANTILE, relabel_by_size
from .result import SupportPlane
from .working_image import WorkingImage

MAX_AREA = 700
"""Size from which a region is kept, px at the reference width."""
MIN_COSINE = 0.25
"""Minimum cosine of the angle between a surface and the view, 75°, for a reading to be reliable.
With 0.2 more ramps stay in real frames, with 0.3 more sides of hidden objects go."""
MAX_STEEP_SHARE = 0.5
"""Maximum share of unreliable readings of a small region."""
MAX_RAMP_SHARE = 0.25
"""The same for a region beside something nearer that is no object, such as a robot: its readings
were filled in or mixed. Such ramps have 0.34 to 0.43 of steep readings."""
MIN_NEARER = 0.05
"""Minimum share of a region's border beside such a thing. It is 0.23 or more at ramps, and at most
0.03 at objects with 0.2 or more of steep readings, in 260 frames."""
NEARER = 1.01
"""Minimum disparity of the nearer reading, in those of the region: 7 mm at 0.7 m."""
REACH = 2
"""Distance of the pixels that are compared across a border, px."""
MIN_SIZE = 200
"""Minimum size of a region that is kept for its level top, or reported, px at the reference width.
Ramps of 120 to 185 px in real frames look the same."""
MAX_DROP, LEVEL = 0.2, 0.005
"""Maximum depth of the middle reading below the highest one, as a share of the region's height, and
the depth that is always allowed, m. Readings of a ramp are spread evenly, or lie at its foot: its
share is 0.43 or more. The narrow top of a hidden object has 0.02 to 0.1, with some mixed readings
below it."""


def remove_steep(
    labels: NDArray[np.int32],
    image: WorkingImage,
    planes: LocalPlanes,
    support: SupportPlane | None,
) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """Drop the small regions that are seen at a grazing angle, and number the others by size.

    At the edge of an object a sensor measures points between the object and what lies behind. They
    form a ramp almost parallel to the view. The faces of walls look the same. A real side of an
    object is rarely visible alone, and at such an angle its shape is not measured. Software that
    fills gaps of depth images makes longer ramps with a flat foot.

    The narrow visible top of an object behind another one is kept. No window lies within it, so
    that its planes cross its edges and are steep, but most of its readings have one height.

    Parameters
    ----------
    labels
        Regions 1..n by size, (H, W).
    image
        Their image.
    planes
        Its local planes.
    support
        The support plane, camera frame, or None.

    Returns
    -------
    labels, lost
        The regions that stay, (H, W) int32, and a mask of the dropped ones that may be objects.
        These are large, and nothing nearer that is no object is beside them.
    """
    sizes = count_labels(labels, int(labels.max(initial=0)))
    small = sizes < image.area(MAX_AREA)
    small[0] = False
    none = np.zeros(labels.shape, np.bool_)
    if not small.any():
        return labels, none
    known, steep = count_steep(labels, small, planes, image.pinhole, MIN_COSINE)
    border, nearer = count_nearer(labels, small, image.disparity, NEARER, REACH)
    ramp = nearer > MIN_NEARER * border
    dropped = steep > np.where(ramp, MAX_RAMP_SHARE, MAX_STEEP_SHARE) * known
    large = dropped & ~ramp & (sizes >= image.area(MIN_SIZE))
    if support is not None:
        for label in np.flatnonzero(large):
            dropped[label] = not _has_level_top(labels == label, image, support)
    if not dropped.any():
        return labels, none
    left = relabel_by_size(np.where(dropped[labels], 0, labels))
    return left, (large & dropped)[labels]


def _has_level_top(mask: NDArray[np.bool_], image: WorkingImage, support: SupportPlane) -> bool:
    """Return whether most readings of a region (H, W) are as high as its top."""
    points = image.points(*np.nonzero(mask & (image.disparity > 0)))
    low, middle, high = np.quantile(support.height(points), (LOW_QUANTILE, 0.5, HIGH_QUANTILE))
    return bool(high - middle <= max(MAX_DROP * (high - low), LEVEL))


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


@njit(cache=True, nogil=True)
def count_nearer(labels, counted, disparity, ratio, reach):
    """Return for each label the pixels with others beside them, and those with nearer background.

    Only labels marked in `counted` (n + 1,) count. Both results are (n + 1,) int64: the pixels
    `reach` px beside the region, and those of them without a label whose `disparity` is at least
    `ratio` times that of the region's pixel.
    """
    height, width = labels.shape
    border, nearer = np.zeros(len(counted), np.int64), np.zeros(len(counted), np.int64)
    for v in range(reach, height - reach):
        for u in range(reach, width - reach):
            label = labels[v, u]
            if not counted[label]:
                continue
            for dv, du in ((-reach, 0), (reach, 0), (0, -reach), (0, reach)):
                other = labels[v + dv, u + du]
                if other != label:
                    border[label] += 1
                    near = disparity[v + dv, u + du] > ratio * disparity[v, u]
                    nearer[label] += other == 0 and near
    return border, nearer

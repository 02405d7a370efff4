"""Join the parts of a vessel whose whole rim is visible: mugs and cups seen from above."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..superquadric.opening import find_opening
from ..superquadric.vessel import Rim
from .connected_parts import connected_parts
from .median import quantile
from .regions import LOW_QUANTILE, fill_holes
from .result import SupportPlane
from .working_image import WorkingImage

MIN_AREA = 700
"""Minimum size of a vessel, px at the reference width."""
MAX_SHARE = 0.85
"""Maximum share of the largest region in a connected group of candidates. Beyond it nothing is
divided."""
SAMPLES = 2000
"""Readings of a group in which a rim is searched."""
NOISE = 0.0015
"""Expected noise of the readings, m: that of the fits."""
MAX_SCALE, MIN_WITHIN = 1.15, 0.8
"""Scale of the rim within which a part of the vessel lies in plan, and the minimum share of its
readings there. A neighbour of the vessel has less."""
EMPTY = ((0.6, 0.25), (0.75, 0.5))
"""Scales of the rim in plan, and shares of the depth above the floor, beyond which an empty vessel
shows nothing there. Contents reach higher, and so do cans and boxes that stand in a circle."""
MAX_FILLED = 0.05
"""Maximum share of readings above these heights: noise."""
RIM_BAND, MIN_RIM = 0.25, 0.05
"""Share of the depth below the rim that belongs to the rim, and the minimum share of a part's
readings there. A small thing in a vessel has none."""
FLOOR_BAND = 0.01
"""Height above the lowest readings up to which a part is the floor, m."""


def join_rims(
    labels: NDArray[np.int32],
    candidates: NDArray[np.bool_],
    image: WorkingImage,
    support: SupportPlane,
) -> NDArray[np.int32]:
    """Join the regions that form one empty vessel with a level rim.

    From above, the walls of a deep vessel are steep and narrow in the image. They fall apart into
    regions that are no objects. Their highest points form a circle or an ellipse, and what lies
    within is much lower. Everything within it then becomes one region, with its unlabelled
    readings. A vessel with contents is left as it is, because these could be joined to it.

    Parameters
    ----------
    labels
        Regions (H, W), 0 = none.
    candidates
        Pixels (H, W) above the supports. Each connected group is searched for a rim.
    image
        Their image.
    support
        The support plane, camera frame.

    Returns
    -------
    NDArray
        (H, W) int32: the regions in arbitrary numbers.
    """
    groups = connected_parts(candidates.astype(np.uint8), diagonal=True)
    joined, following = labels.copy(), int(labels.max(initial=0)) + 1
    for group in np.flatnonzero(groups.sizes[1:] >= image.area(MIN_AREA)) + 1:
        top, left, bottom, right = groups.boxes[group]
        box = slice(top, bottom), slice(left, right)
        mask, numbers = groups.labels[box] == group, labels[box]
        if np.bincount(numbers[mask])[1:].max(initial=0) > MAX_SHARE * groups.sizes[group]:
            continue
        whole = fill_holes(mask) & (image.disparity[box] > 0)
        rows, columns = np.nonzero(whole)
        few = rows[:: len(rows) // SAMPLES + 1], columns[:: len(rows) // SAMPLES + 1]
        points = image.points(few[0] + top, few[1] + left)
        rim, parts = _find_vessel(points, mask[few], numbers[few], support.normal)
        if rim is None or not parts:
            continue
        chosen = np.isin(numbers, parts) & mask
        rows, columns = np.nonzero(whole & (numbers == 0))
        scale = rim.scale(image.points(rows + top, columns + left))
        chosen[rows, columns] = scale < MAX_SCALE
        joined[box][chosen] = following
        following += 1
    return joined


def _find_vessel(
    points: NDArray[np.float64],
    within: NDArray[np.bool_],
    numbers: NDArray[np.int32],
    up: NDArray[np.float64],
) -> tuple[Rim | None, list[int]]:
    """Return the rim of an empty vessel, and the labels of the regions that are its parts.

    `points` are those (N, 3) of a group and those that the camera sees through it. `within` (N,)
    marks the points of the group, and `numbers` (N,) are their labels.
    """
    opening = find_opening(points[within], np.zeros(3), [up], NOISE, points[~within])
    if opening is None:
        return None, []
    scale, heights = opening.rim.scale(points), (points - opening.rim.centre) @ opening.rim.opening
    near = heights[scale < MAX_SCALE]
    if not len(near):
        return None, []
    depth = -quantile(near, LOW_QUANTILE)
    for inner, share in EMPTY:
        high = (scale < inner) & (heights > (share - 1.0) * depth)
        if np.count_nonzero(high) > MAX_FILLED * np.count_nonzero(scale < inner):
            return None, []
    parts = []
    for number in np.unique(numbers[within & (numbers > 0)]):
        own = within & (numbers == number)
        at_rim = np.mean(heights[own] > -RIM_BAND * depth) >= MIN_RIM
        floor = np.mean(heights[own] < FLOOR_BAND - depth) >= MIN_WITHIN
        if (at_rim or floor) and np.mean(scale[own] < MAX_SCALE) >= MIN_WITHIN:
            parts.append(int(number))
    return opening.rim, parts

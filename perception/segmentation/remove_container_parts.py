"""Remove parts of containers from the objects: dividers, round corners, walls above the rim."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .label_pixels import count_labels, renumber_labels
from .measure_container import FoundContainer
from .remove_walls import OUTER_MARGIN, WALL_BAND
from .working_image import WorkingImage

MAX_END_GAP = 0.015
"""Maximum distance of each end of a divider from a wall, m: the error of the walls and the noise of
edges. Longer gaps are beside objects."""
MAX_WIDTH = 0.03
"""Maximum extent of a divider across, m, of its highest readings: two walls of neighbouring
containers with their lips are wider than one sheet."""
MAX_OVER_RIM = 0.01
"""Maximum height of a divider above the rim of its container, m."""
MIN_LEVEL = 0.8
"""Minimum share of the places along a divider whose tops have one height."""
LEVEL = 0.008
"""Maximum distance of a place's top from that height, m."""
PLACES = 16
"""Number of places along a divider."""
MIN_SHARE = 0.3
"""Minimum height of a divider, as a share of the rim's height. It is also higher than `MAX_WIDTH`:
a ruler from wall to wall of a tray is not."""
MIN_COVER = 0.75
"""Minimum share of a wall's length that a region in its plane covers. Sides that slope down to a
low front cover 0.81 and more; things on a rim or at a wall are shorter."""
MIN_RISE = 0.02
"""Minimum height of such a region above the rim, m: more than pens and rulers on a rim."""
CORNER_FOOT = 0.5
"""Maximum height of the lowest readings of a round corner, as a share of the rim's height. What
lies across a corner on the rim shows none so low. It is also taller than `MAX_WIDTH`: a pen across
the corner of a tray is not."""
SAMPLES = 1200
"""Readings of a region that are measured."""


def remove_container_parts(
    labels: NDArray[np.int32], image: WorkingImage, found: list[FoundContainer]
) -> NDArray[np.int32]:
    """Drop the regions that are dividers, corners or walls, and number the others in their order.

    A divider is straight, parallel to two walls of its container, and ends at the other two. Its
    upper edge has one height. The walls between two containers side by side look the same.
    A round corner ends at two walls beside each other. Its upper edge is the rim, and it reaches
    far down.
    A wall above the measured rim lies in the plane of a wall, between its neighbours, along most of
    its length. All else stays: a lost object is worse than a false one.

    Parameters
    ----------
    labels
        Regions 1..n (H, W).
    image
        Their image.
    found
        The containers.
    """
    count = int(labels.max(initial=0))
    if not count or not found:
        return labels
    sizes = count_labels(labels, count)
    stays = np.ones(count + 1, np.bool_)
    stays[0] = False
    for label in range(1, count + 1):
        rows, columns = np.nonzero((labels == label) & (image.disparity > 0))
        step = max(int(sizes[label]) // SAMPLES, 1)
        points = image.points(rows[::step], columns[::step])
        stays[label] = not any(_is_container_part(points, one) for one in found)
    if stays[1:].all():
        return labels
    return renumber_labels(labels, np.where(stays, np.cumsum(stays), 0).astype(np.int32))


def _is_container_part(points: NDArray[np.float64], found: FoundContainer) -> bool:
    """Return whether readings (N, 3) are a divider, a corner or a wall of a container."""
    sides, rim = found.sides, found.container.rim
    if len(sides) != 4 or len(points) < PLACES:
        return False
    heights = found.container.floor.height(points)
    plan = points @ found.support.axes.T
    # Distances inside the inner edges of the rim, for each wall.
    gaps = sides[:, 2] - plan @ sides[:, :2].T + sides[:, 4] * (heights[:, None] - rim)
    foot, top = np.quantile(heights, [0.02, 0.98])
    if top - rim > MAX_OVER_RIM:
        return bool(top - rim >= MIN_RISE and _covers_wall(gaps, sides))
    if top - rim > -LEVEL and foot <= min(CORNER_FOOT * rim, top - MAX_WIDTH):
        for first, second in zip(gaps.T, np.roll(gaps, -1, axis=1).T, strict=True):
            ends = np.quantile([first, second], 0.02, axis=1)
            along, across = (first - second) / np.sqrt(2), (first + second) / np.sqrt(2)
            if (np.abs(ends) <= MAX_END_GAP).all() and _is_sheet(along, across, heights, MAX_WIDTH):
                return True
    for axis in (0, 1):
        ends = np.sort(gaps[:, [axis, axis + 2]], axis=0)[round(0.02 * (len(plan) - 1))]
        if (np.abs(ends) <= MAX_END_GAP).all() and _is_sheet(
            gaps[:, axis], gaps[:, 1 - axis], heights, max(MIN_SHARE * rim, MAX_WIDTH)
        ):
            return True
    return False


def _covers_wall(gaps: NDArray[np.float64], sides: NDArray[np.float64]) -> bool:
    """Return whether readings, by distances (N, 4) from the walls, lie along most of one wall."""
    nearest, low, high = np.quantile(gaps, [0.02, 0.1, 0.9], axis=0)
    between = low > -OUTER_MARGIN
    in_plane = between & (high < WALL_BAND) & (sides[:, 3] > 0)
    for axis in np.flatnonzero(in_plane):
        ends = [axis - 1, (axis + 1) % 4]
        length = sides[ends, 2].sum()
        if between[ends].all() and nearest[ends].clip(0.0).sum() <= (1 - MIN_COVER) * length:
            return True
    return False


def _is_sheet(
    along: NDArray[np.float64],
    across: NDArray[np.float64],
    heights: NDArray[np.float64],
    lowest: float,
) -> bool:
    """Return whether the tops of the places along a region lie on one level line."""
    low, high = along.min(), along.max()
    place = np.minimum(((along - low) / max(high - low, 1e-9) * PLACES).astype(np.intp), PLACES - 1)
    order = np.lexsort((heights, place))
    last = order[np.flatnonzero(np.diff(np.append(place[order], PLACES)))]
    if len(last) < MIN_LEVEL * PLACES:
        return False
    top = float(np.median(heights[last]))
    level = np.abs(heights[last] - top) <= LEVEL
    width = np.ptp(np.quantile(across[heights > top - LEVEL], [0.1, 0.9]))
    return bool(top >= lowest and level.sum() >= MIN_LEVEL * PLACES and width <= MAX_WIDTH)

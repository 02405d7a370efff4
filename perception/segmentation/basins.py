"""Detect basins: parts of a depth image that something higher encloses."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from ..perpendicular import perpendicular_pair
from .block_heights import BLOCK, LOWEST

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .result import SupportPlane
    from .working_image import WorkingImage

GAP = 5
"""Side of the window in which the readings beside a block without readings replace it, blocks."""
MIN_DEPTH = 0.008
"""Minimum depth of a basin, m. It lies below the height of the lowest rim, 0.01 m, by its noise."""
DEPTH_SIGMAS = 4.0
"""Minimum depth of a basin, in σ of the support's readings. Noise has shallower basins."""
MIN_CHANGE = 0.001
"""Change of the water level that is passed on, m. A smaller one takes longer."""
MIN_BLOCKS = 64
"""Minimum size of a basin's bounding box, blocks. The walls of a smaller one are too short."""
MIN_AREA = 0.015
"""Minimum area of a basin in plan, m²: 0.15 x 0.10 m."""
MAX_BASINS = 4
"""Maximum number of basins, the largest first."""
MIN_SLOPE = 0.05
"""Minimum cosine between the normal and the viewing ray of a point of the ring. Other rays are
nearly parallel to the plane."""


class Basin(NamedTuple):
    """A part of the image that something higher encloses."""

    window: tuple[slice, slice]
    """Rows and columns of the image with the basin and the ring around it."""
    outline: NDArray[np.float32]
    """Convex hull (K, 2) of the basin in the image: columns and rows, px."""
    ring: NDArray[np.float64]
    """Points (N, 3) on the ring around it, camera frame, m."""


def find_basins(tops: NDArray[np.float32], image: WorkingImage, plane: SupportPlane) -> list[Basin]:
    """Find the basins of a depth image, largest first.

    The image is a landscape of heights above a plane. Water that cannot run out of the image fills
    the basins (Planchon and Darboux 2002). What stands in a basin may rise out of the water.

    Parameters
    ----------
    tops
        Heights of the blocks above the plane, from :func:`~.block_heights.block_heights`.
    image
        The whole image.
    plane
        A plane of any offset. Its normal is up.
    """
    k = image.intrinsics
    side = image.length(BLOCK)
    beside = np.asarray(cv2.dilate(tops, np.ones((GAP, GAP), np.uint8)), np.float32)
    tops = np.where(tops > LOWEST, tops, beside)
    water = fill_basins(tops)
    depth = max(MIN_DEPTH, DEPTH_SIGMAS * plane.tolerance)
    wet = (water - tops > depth).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(wet, connectivity=4)
    basins: list[tuple[float, Basin]] = []
    sizes = stats[1:count, 2] * stats[1:count, 3]
    for part in np.argsort(-sizes)[:MAX_BASINS] + 1:
        if sizes[part - 1] < MIN_BLOCKS:
            break
        left, top, width, height = stats[part, :4]
        low, high = np.maximum([top - 1, left - 1], 0), [top + height + 1, left + width + 1]
        window = slice(low[0], high[0]), slice(low[1], high[1])
        mask = (labels[window] == part).astype(np.uint8)
        ring = cv2.dilate(mask, np.ones((3, 3), np.uint8)) > mask
        rows, columns = np.nonzero(ring & (tops[window] > LOWEST))
        points = _block_points(rows + low[0], columns + low[1], tops, plane, image, side)
        area = _plan_area(points, plane)
        if area >= MIN_AREA:
            pixels = (
                slice(int(low[0]) * side, min(int(high[0]) * side, k.height)),
                slice(int(low[1]) * side, min(int(high[1]) * side, k.width)),
            )
            hull = np.argwhere(mask)[:, ::-1] + [low[1] + 0.5, low[0] + 0.5]
            outline = cv2.convexHull((side * hull).astype(np.float32)).reshape(-1, 2)
            basins.append((area, Basin(pixels, np.asarray(outline, np.float32), points)))
    basins.sort(key=lambda item: -item[0])
    return [basin for _, basin in basins]


def _block_points(
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    tops: NDArray[np.float32],
    plane: SupportPlane,
    image: WorkingImage,
    side: int,
) -> NDArray[np.float64]:
    """Return the points (N, 3) at the height of blocks, on the rays through their centres, m."""
    k = image.intrinsics
    u, v = (columns + 0.5) * side - 0.5, (rows + 0.5) * side - 0.5
    rays = np.column_stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(len(u))])
    slope = rays @ plane.normal
    z = (tops[rows, columns] - plane.offset) / np.minimum(slope, -MIN_SLOPE)
    return rays[slope < -MIN_SLOPE] * z[slope < -MIN_SLOPE, None]


def _plan_area(points: NDArray[np.float64], plane: SupportPlane) -> float:
    """Return the area of the convex hull of points (N, 3) in plan, m²."""
    if not len(points):
        return 0.0
    plan = (points @ perpendicular_pair(plane.normal).T).astype(np.float32)
    return float(cv2.contourArea(cv2.convexHull(plan)))


@njit(cache=True, nogil=True)
def fill_basins(tops):
    """Return the water level over a landscape (H, W): its height where nothing holds water."""
    rows, columns = tops.shape
    water = np.full((rows, columns), np.inf, np.float32)
    water[0], water[-1] = tops[0], tops[-1]
    water[:, 0], water[:, -1] = tops[:, 0], tops[:, -1]
    changed = True
    while changed:
        changed = False
        for turn in range(2):
            for i in range(1, rows - 1):
                v = i if turn == 0 else rows - 1 - i
                for j in range(1, columns - 1):
                    u = j if turn == 0 else columns - 1 - j
                    here = water[v, u]
                    if here <= tops[v, u]:
                        continue
                    level = min(water[v - 1, u], water[v + 1, u], water[v, u - 1], water[v, u + 1])
                    level = max(level, tops[v, u])
                    if level < here - MIN_CHANGE:
                        water[v, u] = level
                        changed = True
    return water

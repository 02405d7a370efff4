"""Select the regions that can be lifted: those that stand on a support and have a liftable size."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from .above_support import BOARD, OVERHANG
from .edge_boards import divided_boards, edge_board
from .hull_depth import depth_in_hull
from .label_pixels import count_labels, pixels_by_label, renumber_labels
from .median import median
from .point_extent import box_diagonal, trimmed_range
from .regions import LOW_QUANTILE, MAX_REGIONS
from .select_supports import MIN_GAP, is_floor
from .support_extent import Support
from .walls import is_board, is_side, is_wall
from .working_image import WorkingImage

HULL_MARGIN = 0.012
"""Maximum distance of an object's foot outside the support's hull, m."""
FOOT_SHARE = 0.15
"""Share of a region's height that is its foot, from below."""
MIN_FOOT = 0.01
"""Minimum height of a foot, m."""
MIN_TOP_WAVES = 3.0
"""Minimum height of an object's top, in heights of the support's waves. Lower regions are waves."""
MIN_FOOT_INSIDE = 0.5
"""Minimum share of an object's foot over the hull."""
CUT_OUTLIERS = 0.01
"""Share of outliers at each end of a region that the image cuts off. The region is larger than its
visible part. With 0.02 the frames of some shelves are not too large for an object."""
MAX_CUT_LENGTH = 0.15
"""Maximum length at which the image border cuts an object off, m. A wall or a robot is longer."""
RESTING_MARGIN = 0.06
"""The same for an object whose lowest visible point lies on the support, m. It may hide the corner
of the support on which it stands."""
MAX_GAP_BELOW = 0.015
"""Maximum distance of that point from the support, m."""
MAX_BOTTOM = 0.4
"""Maximum height of an object's lowest visible point over its support, m. A higher one hangs on a
wall or stands on a board that is not visible."""
MIN_OVER_BOARD = 0.01
"""Minimum distance inside a board's hull at which a reading is above or below the board, m."""
MIN_PASSING = 0.1
"""Minimum share of the readings of a side of furniture above a board, and the same below it."""
SEAM_HEIGHT = 2.0
"""Maximum height of a seam, in heights of one pixel on the support."""
MAX_SEAM_INTERIOR = 0.1
"""Maximum share of a seam's pixels with four neighbours in it. Seams are one or two pixels wide."""
BOARD_MARGIN = 0.01
"""Maximum distance of a piece of a board above or below the board's front edge, m."""
MAX_FRAME = 0.5
"""Maximum diagonal of a region that fills little of its outline, m. The frame of a shelf is
larger."""
MIN_SOLIDITY = 0.3
"""Minimum share of a larger region's convex outline that its pixels fill. No object of the real
frames with points or labels is lost."""
MAX_PLAY = 0.02
"""Maximum distance of a leg's highest candidates from their limit, m."""
BORDER = 2
"""Distance from the border of the image at which it cuts objects off, px."""
SAMPLES = 300
"""Pixels of a region from which its foot and extent are computed."""
FOOT_SAMPLES = 60
"""Pixels of a foot whose positions are compared with the hull."""


class _Region(NamedTuple):
    """Samples of one region."""

    points: NDArray[np.float64]
    """(N, 3), m, camera frame."""
    cut_points: NDArray[np.float64]
    """(M, 3) those at the border of the image, m."""


def select_objects(
    labels: NDArray[np.int32],
    image: WorkingImage,
    supports: list[Support],
    min_size: int,
    max_extent: float,
) -> NDArray[np.int32]:
    """Number the regions by size and drop those that cannot be objects.

    Parameters
    ----------
    labels
        Regions (H, W), 0 = none.
    image
        Their image. It is larger than the regions except at the border of the whole image.
    supports
        The foot of an object stands over the hull of one of them, or on a board of which only the
        edge is visible. What stands on the floor around a table counts only if there is no other
        object. Without any support, only sizes count.
    min_size
        Minimum size of a region, px.
    max_extent
        Maximum diagonal of a region's bounding box, m.

    Returns
    -------
    NDArray
        (H, W) int32: 1..n = kept regions, largest first. Only the ``MAX_REGIONS`` largest ones are
        checked. Smaller ones are kept.
    """
    sizes = count_labels(labels, int(labels.max(initial=0)))
    sizes[0] = 0
    order = np.argsort(-sizes, kind="stable")
    order = order[sizes[order] >= min_size]
    order_of_pixels, starts = pixels_by_label(labels, len(sizes) - 1)
    regions = []
    for label in order[:MAX_REGIONS]:
        pixels = order_of_pixels[starts[label] : starts[label + 1]]
        regions.append(_Region(*sample_region(pixels, image.disparity, image.pinhole)))
    boards: list[NDArray[np.float64]] = []
    edges = [_find_board(region.points, supports, boards) for region in regions]
    boards += divided_boards([region.points for region in regions], supports)
    floors = [support for support in supports if is_floor(support, supports[0])]
    work = [support for support in supports if all(support is not one for one in floors)]
    work += [edge for edge in edges if edge is not None]
    kept, on_floor = [], []
    for rank, label in enumerate(order):
        if rank < MAX_REGIONS:
            region, pixels = regions[rank], order_of_pixels[starts[label] : starts[label + 1]]
            if supports and _is_seam(region, pixels, labels, supports[0], image):
                continue
            if supports and _lies_on_board(region.points, supports[0], boards):
                continue
            if supports and _is_frame(region.points, len(pixels), image):
                continue
            if not _is_object(region, work, image, max_extent):
                if floors and _is_object(region, floors, image, max_extent):
                    on_floor.append(label)
                continue
        kept.append(label)
    renumber = np.zeros(len(sizes), np.int32)
    # The first support may be a chair. If nothing stands on it, the floor is the work surface.
    kept = kept or on_floor
    renumber[kept] = np.arange(1, len(kept) + 1)
    return renumber_labels(labels, renumber)


def _is_object(
    region: _Region, supports: list[Support], image: WorkingImage, max_extent: float
) -> bool:
    """Return whether a region of liftable size stands on one of the supports."""
    points, cut_points = region
    if not len(points):
        return False
    if supports and is_side(points, supports):
        return False
    outliers = CUT_OUTLIERS if len(cut_points) else LOW_QUANTILE
    if box_diagonal(points) > max_extent and _trimmed_diagonal(points, outliers) > max_extent:
        return False
    if not supports:
        return True
    if len(cut_points) and np.linalg.norm(np.ptp(cut_points, axis=0)) > MAX_CUT_LENGTH:
        return False
    if any(_passes_through(points, support) for support in supports):
        return False
    for support in supports:
        heights = support.plane.height(points)
        bottom, top = trimmed_range(heights, LOW_QUANTILE)
        highest = trimmed_range(heights / points[:, 2] ** 2, LOW_QUANTILE)[1]
        if bottom > MAX_BOTTOM:
            continue
        if highest < MIN_TOP_WAVES * support.wave or _holds_board(top, support, supports):
            continue
        foot = points[heights <= bottom + max(FOOT_SHARE * (top - bottom), MIN_FOOT)]
        foot = foot[:: max(len(foot) // FOOT_SAMPLES, 1)]
        depths = depth_in_hull(foot @ support.axes.T, support.hull)
        resting = abs(bottom) < MAX_GAP_BELOW
        margin = -RESTING_MARGIN if resting else -HULL_MARGIN
        if support.foot_margin is not None:
            margin = support.foot_margin
        inside = depths > margin
        if len(cut_points) and support.foot_margin is None:
            # It may stand on a part of the support outside the image.
            inside |= (depths > -OVERHANG) & _stands_outside(foot, support, image)
        if np.count_nonzero(inside) >= MIN_FOOT_INSIDE * len(foot):
            return not is_wall(points, support)
    return False


def _stands_outside(
    foot: NDArray[np.float64], support: Support, image: WorkingImage
) -> NDArray[np.bool_]:
    """Return a mask (N,) of points (N, 3) below which the support is outside the image."""
    below = foot - support.plane.height(foot)[:, None] * support.plane.normal
    pixels = image.intrinsics.project(below)
    last = np.array(image.depth.shape[::-1]) - 1 - BORDER
    # NaN behind the camera fails the comparisons.
    return ~np.all((pixels >= BORDER) & (pixels <= last), axis=1)


def _passes_through(points: NDArray[np.float64], support: Support) -> bool:
    """Return whether a region extends above and below a board: a side of the furniture."""
    heights = support.plane.height(points)
    if heights.min() >= -2 * BOARD:
        return False
    over = depth_in_hull(points @ support.axes.T, support.hull) > MIN_OVER_BOARD
    least = MIN_PASSING * len(points)
    return bool(
        np.count_nonzero(over & (heights > BOARD)) >= least
        and np.count_nonzero(over & (heights < -2 * BOARD)) >= least
    )


def _find_board(
    points: NDArray[np.float64], supports: list[Support], boards: list[NDArray[np.float64]]
) -> Support | None:
    """Return the support on a board of which the image shows the front edge, or None.

    The heights (2,) of the board are added to `boards`.
    """
    if not len(points) or not any(is_board(points, support) for support in supports):
        return None
    boards.append(np.array(trimmed_range(points @ supports[0].plane.normal, LOW_QUANTILE)))
    return edge_board(points, supports)


def _lies_on_board(
    points: NDArray[np.float64], support: Support, boards: list[NDArray[np.float64]]
) -> bool:
    """Return whether a region is a board, or a piece of one at the same height.

    The noise of a board at a grazing angle leaves pieces of it.
    """
    if not len(points) or not boards:
        return False
    low, high = trimmed_range(points @ support.plane.normal, LOW_QUANTILE)
    return any(low > board[0] - BOARD_MARGIN and high < board[1] + BOARD_MARGIN for board in boards)


def _is_frame(points: NDArray[np.float64], size: int, image: WorkingImage) -> bool:
    """Return whether a region of `size` px is large and thin: the front edges of a shelf."""
    if box_diagonal(points) < MAX_FRAME:
        return False
    directions = (points[:, :2] / points[:, 2:]).astype(np.float32)
    outline = cv2.contourArea(cv2.convexHull(directions))
    k = image.intrinsics
    return size < MIN_SOLIDITY * outline * k.fx * k.fy


def _is_seam(
    region: _Region,
    pixels: NDArray[np.int32],
    labels: NDArray[np.int32],
    support: Support,
    image: WorkingImage,
) -> bool:
    """Return whether a region is a seam that the median filter leaves at the foot of an object.

    The filter moves readings by a pixel there. On a slanted support this is a height.
    """
    if not len(region.points):
        return False
    normal, k = np.abs(support.plane.normal), image.intrinsics
    pixel = median(region.points[:, 2]) * max(normal[0] / k.fx, normal[1] / k.fy)
    if median(support.plane.height(region.points)) > SEAM_HEIGHT * pixel:
        return False
    return bool(count_inner(pixels, labels) / len(pixels) < MAX_SEAM_INTERIOR)


def _holds_board(top: float, support: Support, supports: list[Support]) -> bool:
    """Return whether a region up to height `top` over a support reaches the next higher support.

    It is a leg or a side of the furniture: readings above this height were no candidates.
    """
    gaps = [support.plane.offset - other.plane.offset for other in supports]
    return any(gap - BOARD - MAX_PLAY < top < gap for gap in gaps if gap >= MIN_GAP)


def _trimmed_diagonal(points: NDArray[np.float64], outliers: float) -> float:
    """Return the diagonal of the bounding box of points (N, 3) without outliers at each side."""
    ends = [trimmed_range(values, outliers) for values in points.T.copy()]
    return float(np.linalg.norm(np.ptp(ends, axis=1)))


@njit(cache=True, nogil=True)
def sample_region(pixels, q, pinhole):
    """Return the fields of `_Region` from the flat pixels of a region and the disparity (H, W)."""
    fx, fy, cx, cy = pinhole
    rows, columns = q.shape
    flat = q.ravel()
    valid = cut = 0
    # The pixels are sorted, so that the row follows from the last one. Divisions take long.
    v = -1
    for pixel in pixels:
        if flat[pixel] > 0:
            v = _row_of(pixel, v, columns)
            valid += 1
            cut += _is_cut(v, pixel - v * columns, rows, columns)
    step = max(valid // SAMPLES, 1)
    points, cut_points = np.empty((-(-valid // step), 3)), np.empty((cut, 3))
    i = j = 0
    v = -1
    for pixel in pixels:
        if flat[pixel] <= 0:
            continue
        v = _row_of(pixel, v, columns)
        u = pixel - v * columns
        is_cut = _is_cut(v, u, rows, columns)
        if i % step == 0 or is_cut:
            z = 1.0 / np.float64(flat[pixel])
            x, y = (u - cx) / fx * z, (v - cy) / fy * z
            if i % step == 0:
                k = i // step
                points[k, 0], points[k, 1], points[k, 2] = x, y, z
            if is_cut:
                cut_points[j, 0], cut_points[j, 1], cut_points[j, 2] = x, y, z
                j += 1
        i += 1
    return points, cut_points


@njit(cache=True, nogil=True)
def _row_of(pixel, row, columns):
    """Return the row of a pixel, for the row of an earlier one or -1."""
    if row < 0:
        return pixel // columns
    while pixel >= (row + 1) * columns:
        row += 1
    return row


@njit(cache=True, nogil=True)
def _is_cut(v, u, rows, columns):
    return v < BORDER or u < BORDER or v >= rows - BORDER or u >= columns - BORDER


@njit(cache=True, nogil=True)
def count_inner(pixels, labels):
    """Count the pixels of a region (N,) whose neighbours in rows and columns belong to it."""
    flat, columns = labels.ravel(), labels.shape[1]
    last = flat.size - 1
    count = 0
    for pixel in pixels:
        label = flat[pixel]
        above, below = flat[max(pixel - columns, 0)], flat[min(pixel + columns, last)]
        left, right = flat[max(pixel - 1, 0)], flat[min(pixel + 1, last)]
        count += (above == label) & (below == label) & (left == label) & (right == label)
    return count

"""Select the supports among the planes of an image: tables, and the boards of shelves."""

from __future__ import annotations

import cv2
import numpy as np

from .median import median
from .open_edges import open_share
from .parallel_planes import FlatReadings, parallel_planes
from .support_extent import Support, locate_support
from .working_image import WorkingImage

MAX_SUPPORTS = 4
"""Maximum number of supports."""
MIN_DISTANCE = 0.015
"""Minimum distance between two supports, m."""
MIN_COSINE = 0.95
"""Minimum cosine between the normals of parallel planes."""
MIN_AREA = 0.15
"""Minimum visible area of a further support, m². Smaller parallel planes are faces of objects."""
MIN_BOARD_AREA = 0.05
"""The same for a plane at least ``MIN_GAP`` above or below the others, such as a board."""
MIN_GAP = 0.2
"""Minimum distance between boards, m."""
MIN_FIRST_AREA = 0.015
"""Minimum visible area of the first support, m²: a sheet of 0.15 x 0.10 m."""
MIN_STACK = 0.1
"""Minimum distance between a small board and the best plane, m. A box that overhangs the one below
it also has an open space below its edge, but its top is lower."""
MIN_COVERED_AREA, MIN_COVERED_HULL = 0.006, 0.02
"""The same for a small table that objects cover, and minimum area of its hull, m². Parts of other
things have smaller hulls."""
MIN_RIVAL_SCORE = 0.3
"""Minimum score, relative to the best one, of a plane that can take the place of the best one."""
MIN_BOARD_SCORE = 0.05
"""The same for a plane with an open space below its front edge."""
MIN_OPEN = 0.7
"""Minimum share of the front edge of a board below which the space is open."""
MAX_TOP_AREA = 0.15
"""Maximum area of the top of an object, m²."""
MAX_TOP_HEIGHT = 0.25
"""Maximum height of an object whose top is no support, m."""
MAX_DROP = 0.6
"""Height below another support from which a plane is the floor, m. The space above the floor around
a table is not the work space."""
MIN_UNDER, MAX_BOARD_RATIO = 0.4, 2.0
"""Minimum share of a plane at least ``MIN_GAP`` below the first support that lies under it, and
maximum area of its hull relative to that of the first one. A plane that violates both is the floor
around a table. Chosen on small tables of seeds 2000 to 2015, where the share is 0.1."""
MAX_SHELF_AREA = 1.0
"""Maximum visible area of a support below the first one, m². A larger plane is the floor."""


def select_supports(supports: list[Support], image: WorkingImage) -> list[Support]:
    """Select the supports among planes that are sorted by score, best first."""
    if not supports:
        return []
    normal = supports[0].plane.normal
    parallel = [one for one in supports if abs(float(one.plane.normal @ normal)) > MIN_COSINE]
    best = supports[0].score
    # A plane with a clear space below its front edge is a board or a table, never a box or a floor.
    boards = [
        len(parallel) > 1
        and one.score >= MIN_BOARD_SCORE * best
        and (one is supports[0] or _is_apart(one, supports[0]))
        and open_share(one.plane, one.hull, one.axes, image) >= MIN_OPEN
        for one in parallel
    ]
    rivals = [
        (one, board)
        for one, board in zip(parallel, boards, strict=True)
        if board or one.score >= MIN_RIVAL_SCORE * best
    ]

    def is_top(one: Support) -> bool:
        return one.area < MAX_TOP_AREA and any(
            0 < other.plane.offset - one.plane.offset < MAX_TOP_HEIGHT and other.area > one.area
            for other, _ in rivals
        )

    def lies_below(one: Support) -> bool:
        return any(one.plane.offset - other.plane.offset > MAX_TOP_HEIGHT for other, _ in rivals)

    suitable = [one for one, board in rivals if board or not (is_top(one) or lies_below(one))]
    first = suitable[0] if suitable else supports[0]
    selected = [first]
    for one, board in zip(parallel, boards, strict=True):
        apart = min(abs(one.plane.offset - other.plane.offset) for other in selected)
        drop = one.plane.offset - first.plane.offset
        shelf = drop < 0 or (drop <= MAX_DROP and one.area <= MAX_SHELF_AREA)
        min_area = MIN_AREA if apart < MIN_GAP else MIN_BOARD_AREA
        if apart > MIN_DISTANCE and (board or (shelf and one.area >= min_area)):
            selected.append(one)
    rejected = [
        one
        for one in supports
        if all(abs(one.plane.offset - other.plane.offset) > MIN_DISTANCE for other in selected)
    ]
    selected[0] = first._replace(runner_up=rejected[0] if rejected else None)
    return selected[:MAX_SUPPORTS]


def further_boards(
    readings: FlatReadings, supports: list[Support], image: WorkingImage
) -> tuple[list[Support], list[Support]]:
    """Return the boards and tables parallel to the best support that are not among the supports.

    The second list holds those of which too little is visible. Parts of a robot look the same.
    """
    boards: list[Support] = []
    small: list[Support] = []
    best = supports[0]
    for plane, points in parallel_planes(readings, best.plane.normal):
        known = any(
            abs(plane.offset - one.plane.offset) < MIN_DISTANCE
            and float(one.plane.normal @ plane.normal) > MIN_COSINE
            for one in supports
        )
        plan = np.ascontiguousarray((points @ best.axes.T).astype(np.float32))
        hull = np.asarray(cv2.convexHull(plan), np.float32).reshape(-1, 2)
        if known or open_share(plane, hull, best.axes, image) < MIN_OPEN:
            continue
        board = locate_support(plane, float(median(points[:, 2])), image)
        if board is None or board.area < MIN_COVERED_AREA or not _is_apart(board, best):
            continue
        if board.score >= MIN_BOARD_SCORE * best.score and _is_large(board):
            boards.append(board)
        else:
            small.append(board)
    return boards, small


def with_small_table(first: Support, small: list[Support]) -> Support:
    """Return the first support with a plane high above it as its runner-up, if there is one."""
    high = [one for one in small if first.plane.offset - one.plane.offset > MAX_TOP_HEIGHT]
    return first._replace(runner_up=high[0]) if high else first


def is_floor(support: Support, first: Support) -> bool:
    """Return whether a support is the floor around the first one: lower, larger, and beside it.

    What stands there is no object of the scene. The boards of a shelf have one size.
    """
    if support.plane.offset - first.plane.offset < MIN_GAP:
        return False
    above = cv2.convexHull(first.hull)
    hull = cv2.convexHull((support.hull @ (support.axes @ first.axes.T)).astype(np.float32))
    area = cv2.contourArea(hull)
    if area <= MAX_BOARD_RATIO * cv2.contourArea(above):
        return False
    return bool(cv2.intersectConvexConvex(above, hull)[0] < MIN_UNDER * area)


def _is_large(board: Support) -> bool:
    """Return whether a plane has the size of a table, of which objects may cover most."""
    return cv2.contourArea(board.hull) >= MIN_COVERED_HULL or board.area >= MIN_FIRST_AREA


def _is_apart(board: Support, best: Support) -> bool:
    """Return whether a plane is too large, or too far from the best one, for the top of a stack."""
    gap = abs(board.plane.offset - best.plane.offset)
    return gap >= MIN_STACK or board.area >= MIN_AREA

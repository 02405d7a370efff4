"""Propose rims of containers: horizontal rectangles of edges at one height."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .block_heights import BLOCK, LOWEST
from .container_walls import MAX_THICKNESS, MIN_RIM
from .median import median
from .result import SupportPlane
from .rim_votes import (
    LAYER,
    MIN_LENGTH,
    PLACE,
    count_visible,
    cover_places,
    search_rectangle,
    side_peaks,
    vote_turns,
)
from .working_image import WorkingImage

MAX_HEIGHT = 1.2
"""Maximum height of a rim above the support, m. A container may stand on a table above the floor of
the room."""
DROP_WINDOW = 5
"""Side of the window in which a reading beside an edge lies lower, blocks."""
MIN_DROP = 0.006
"""Minimum height of an edge over that reading, m: the lowest rim, 0.01 m, less its noise."""
MIN_SLOPE = 0.05
"""Minimum cosine between the normal and the viewing ray of an edge. Other rays are nearly parallel
to the plane."""
MAX_LENGTH = 1.3
"""Maximum length of a container, m. Larger ones are rooms."""
TURN = np.radians(3.0)
"""Angle between the orientations of the first search, rad. It moves the end of a side of 0.3 m by
one bin."""
FINE_TURNS = np.radians(np.arange(-2.0, 3.0))
"""Angles around the best one that are tried then, rad."""
MAX_LAYERS = 8
"""Number of layers in which rectangles are searched, those with the most votes first."""
MIN_WHOLE_COVER = 0.75
"""Minimum share of covered places of all sides. Sides between unrelated things have less."""
MIN_VISIBLE_COVER = 0.85
"""Minimum share of covered places among the visible ones of each side, if contents hide others.
Heaped bins of seeds 2000 to 2015 have 0.9, rectangles across their contents 0.6."""
MIN_AREA = 0.015
"""Minimum area of a rim, m²: 0.15 x 0.10 m."""
MIN_KEPT = 0.7
"""Minimum evidence of a higher rectangle around the same place, relative to the lower one."""
MAX_MISSES = 6
"""Number of layers without such a rectangle after which no higher one is searched. A lip of 2 cm
hides the edges below it."""
MAX_LEVEL = 0.6
"""Maximum share of readings inside that are level with the rim. The top of a box is."""


class Rim(NamedTuple):
    """A rectangle that may be the rim of a container."""

    corners: NDArray[np.float64]
    """Corners (4, 2) in plan, m, counterclockwise."""
    height: float
    """Height above the plane, m."""
    place: RimPlace
    """Its place in the image."""


class RimPlace(NamedTuple):
    """The part of the image within a rim."""

    window: tuple[slice, slice]
    """Rows and columns of the image around the rim."""
    outline: NDArray[np.float32]
    """Corners (K, 2) of the rim in the image: columns and rows, px."""
    ring: NDArray[np.float64]
    """Points (K, 3) on the rim, camera frame, m."""


class _Rectangle(NamedTuple):
    """A rectangle of edges in one layer."""

    corners: NDArray[np.float64]
    """Corners (4, 2) in plan, m, counterclockwise."""
    height: float
    """Median height of the edges of its layer, m."""
    evidence: float
    """Length of its covered places over `MIN_COVER`, m."""
    lowest: float
    """Lower bound of the lowest layer with this rectangle, m."""


class _Edges(NamedTuple):
    """Blocks of the image with something lower beside them."""

    plan: NDArray[np.float64]
    """Plan coordinates (N, 2), m."""
    heights: NDArray[np.float64]
    """Heights (N,) above the plane, m."""
    sizes: NDArray[np.float64]
    """Lengths (N,) of the blocks, m."""


def find_rims(tops: NDArray[np.float32], image: WorkingImage, plane: SupportPlane) -> list[Rim]:
    """Propose rims of containers, the one with the longest edges first. They do not overlap.

    All sides of a rim have one height, and something beside them lies lower. In each layer of
    heights the edges vote for an orientation, and then for sides. Objects over the rim, gaps and
    the border of the image interrupt the sides, but leave the rectangle.

    Parameters
    ----------
    tops
        Heights of the blocks above the plane, from :func:`~.block_heights.block_heights`.
    image
        The whole image.
    plane
        A plane below the rims. Its normal is up.
    """
    edges = _find_edges(tops, image, plane)
    layers = int(MAX_HEIGHT / (LAYER / 2))
    turns = np.arange(0.0, np.pi / 2, TURN)
    votes = vote_turns(*edges, layers, turns)
    found: list[_Rectangle] = []
    for layer in np.argsort(-votes.max(axis=1))[:MAX_LAYERS].tolist():
        if votes[layer].max() <= 0:
            break
        if any(one.lowest <= layer * LAYER / 2 <= one.height for one in found):
            continue
        own = _in_layer(edges, layer)
        near = turns[votes[layer].argmax()] + FINE_TURNS
        angle = float(near[vote_turns(*own, 1, near)[0].argmax()])
        best = _best_rectangle(own, angle, layer * LAYER / 2, image, plane)
        if best is not None:
            found.append(_highest(best, edges, layer, angle, (image, plane)))
    rims: list[Rim] = []
    for one in sorted(found, key=lambda one: -one.evidence):
        rim = Rim(one.corners, one.height, locate(one.corners, one.height, plane, image))
        if not any(_overlap(rim, other) for other in rims) and _is_hollow(rim, tops, image, plane):
            rims.append(rim)
    return rims


def locate(
    corners: NDArray[np.float64], height: float, plane: SupportPlane, image: WorkingImage
) -> RimPlace:
    """Return the place in the image of a polygon (K, 2) in plan at a height above a plane, m."""
    ring = corners @ perpendicular_pair(plane.normal) + (height - plane.offset) * plane.normal
    outline = image.intrinsics.project(ring).astype(np.float32)
    size = np.array(image.depth.shape[::-1])
    low = np.clip(np.floor(outline.min(axis=0)), 0, size - 1).astype(int)
    high = np.clip(np.ceil(outline.max(axis=0)) + 1, low + 1, size).astype(int)
    return RimPlace((slice(low[1], high[1]), slice(low[0], high[0])), outline, ring)


def _find_edges(tops: NDArray[np.float32], image: WorkingImage, plane: SupportPlane) -> _Edges:
    """Return the blocks with something lower, or nothing, beside them, within reach of a rim."""
    k, side = image.intrinsics, image.length(BLOCK)
    low = np.asarray(cv2.erode(tops, np.ones((DROP_WINDOW, DROP_WINDOW), np.uint8)))
    high = (tops > MIN_RIM) & (tops < MAX_HEIGHT)
    rows, columns = np.nonzero(high & (tops - low > MIN_DROP))
    u, v = (columns + 0.5) * side - 0.5, (rows + 0.5) * side - 0.5
    rays = np.column_stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(len(u))])
    slope = np.minimum(rays @ plane.normal, -MIN_SLOPE)
    heights = tops[rows, columns].astype(np.float64)
    z = (heights - plane.offset) / slope
    plan = (rays * z[:, None]) @ perpendicular_pair(plane.normal).T
    if not len(plan):
        return _Edges(plan, heights, z)
    near = (slope < -MIN_SLOPE) & (np.abs(plan - np.median(plan, axis=0)).max(axis=1) < MAX_LENGTH)
    return _Edges(plan[near], heights[near], side * z[near] / k.fx)


def _in_layer(edges: _Edges, layer: int) -> _Edges:
    """Return the edges in a layer, with heights above its lower bound."""
    heights = edges.heights - layer * LAYER / 2
    part = (heights >= 0) & (heights < LAYER)
    return _Edges(edges.plan[part], heights[part], edges.sizes[part])


def _highest(
    best: _Rectangle,
    edges: _Edges,
    layer: int,
    angle: float,
    view: tuple[WorkingImage, SupportPlane],
) -> _Rectangle:
    """Return the highest rectangle above one of a layer. The inner faces of walls have edges too.

    Each layer up to it holds a rectangle with nearly as long edges.
    """
    misses, least = 0, MIN_KEPT * best.evidence
    while misses <= MAX_MISSES:
        layer += 1
        own = _in_layer(edges, layer)
        higher = None
        if own.sizes.sum() > MIN_LENGTH:
            higher = _best_rectangle(own, angle, layer * LAYER / 2, *view)
        if higher is None or higher.evidence < least:
            misses += 1
            continue
        best, misses = higher._replace(lowest=best.lowest), 0
    return best


def _best_rectangle(
    edges: _Edges, angle: float, base: float, image: WorkingImage, plane: SupportPlane
) -> _Rectangle | None:
    """Return the rectangle of one orientation with the longest edges, or None if all are short.

    The heights of the edges are those above `base`, m.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    turned = edges.plan @ np.array([[cos, -sin], [sin, cos]])
    low = turned.min(axis=0)
    x, y = turned[:, 0], turned[:, 1]
    xs, ys = side_peaks(x, edges.sizes), side_peaks(y, edges.sizes)
    covered = cover_places(x, y - low[1], xs), cover_places(y, x - low[0], ys)
    view = image, plane, float(median(edges.heights)) + base
    axes = np.array([[cos, sin], [-sin, cos]])
    seen = (
        _seen_places(xs, low[1], covered[0].shape[1] - 1, axes, view),
        _seen_places(ys, low[0], covered[1].shape[1] - 1, axes[::-1], view),
    )
    (x0, x1, y0, y1), evidence, cover, visible = search_rectangle(xs, ys, covered, seen, low)
    width, depth = x1 - x0, y1 - y0
    if cover < MIN_WHOLE_COVER and visible < MIN_VISIBLE_COVER:
        return None
    if width * depth < MIN_AREA or max(width, depth) > MAX_LENGTH:
        return None
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return _Rectangle(corners @ axes, view[2], evidence, base)


def _seen_places(
    sides: NDArray[np.float64],
    low: float,
    places: int,
    axes: NDArray[np.float64],
    view: tuple[WorkingImage, SupportPlane, float],
) -> NDArray[np.int32]:
    """Count the places within the image, and the visible ones, before each place along each side.

    `axes` are the directions across and along the sides in plan as rows. `view` is the image, the
    plane, and the height of the sides above it, m.
    """
    image, plane, height = view
    along = low + (np.arange(places) + 0.5) * PLACE
    directions = axes @ perpendicular_pair(plane.normal)
    base = sides[:, None] * directions[0] + (height - plane.offset) * plane.normal
    return count_visible(base, along, directions[1], image.pinhole, image.depth)


def _overlap(rim: Rim, other: Rim) -> bool:
    """Return whether the middle of one rim lies in the other."""
    for one, two in ((rim, other), (other, rim)):
        x, y = one.corners.mean(axis=0)
        outline = two.corners.astype(np.float32)
        if cv2.pointPolygonTest(outline, (float(x), float(y)), False) >= 0:
            return True
    return False


def _is_hollow(
    rim: Rim, tops: NDArray[np.float32], image: WorkingImage, plane: SupportPlane
) -> bool:
    """Return whether most readings within a rim lie above or below it."""
    middle = rim.corners.mean(axis=0)
    arms = rim.corners - middle
    half = np.linalg.norm(arms[1] - arms[0]) / 2, np.linalg.norm(arms[2] - arms[1]) / 2
    shrunk = middle + arms * (1.0 - MAX_THICKNESS / min(half))
    outline = locate(shrunk, rim.height, plane, image).outline / image.length(BLOCK)
    inside = np.zeros(tops.shape, np.uint8)
    cv2.fillConvexPoly(inside, np.rint(outline).astype(np.int32), 1)
    heights = tops[(inside > 0) & (tops > LOWEST)]
    return bool(len(heights) and np.mean(np.abs(heights - rim.height) < MIN_RIM) < MAX_LEVEL)

"""Propose rims of containers: horizontal rectangles of edges at one height."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from ..perpendicular import perpendicular_pair
from .block_heights import BLOCK, LOWEST
from .container_walls import LEVEL_BAND, MAX_THICKNESS, MIN_RIM, MIN_SIDE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .result import SupportPlane
    from .working_image import WorkingImage

MAX_HEIGHT = 0.6
"""Maximum height of a rim above the support, m."""
DROP_WINDOW = 5
"""Side of the window in which a reading beside an edge lies lower, blocks."""
MIN_DROP = 0.006
"""Minimum height of an edge over that reading, m: the lowest rim, 0.01 m, less its noise."""
MIN_SLOPE = 0.05
"""Minimum cosine between the normal and the viewing ray of an edge. Other rays are nearly parallel
to the plane."""
LAYER = 0.01
"""Height of a layer, m: the scatter of one rim. Layers overlap by half."""
MAX_LENGTH = 1.3
"""Maximum length of a container, m. Larger ones are rooms."""
TURN = np.radians(3.0)
"""Angle between the orientations of the first search, rad. It moves the end of a side of 0.3 m by
one bin."""
FINE_TURNS = np.radians(np.arange(-2.0, 3.0))
"""Angles around the best one that are tried then, rad."""
BIN = 0.008
"""Width of the bins in which edges vote for a side, m."""
MAX_LAYERS = 8
"""Number of layers in which rectangles are searched, those with the most votes first."""
PEAKS = 5
"""Number of possible sides along each direction, those with the most votes first."""
PLACE = 0.015
"""Length of the places along a side, m. Edges cover a place or not."""
MIN_COVER = 0.4
"""Share of covered places from which a side speaks for a rectangle."""
MIN_WHOLE_COVER = 0.75
"""Minimum share of covered places of all sides. Sides between unrelated things have less."""
MIN_AREA = 0.015
"""Minimum area of a rim, m²: 0.15 x 0.10 m."""
MIN_LENGTH = 0.12
"""Minimum length of the edges in a layer, m."""
MIN_KEPT = 0.7
"""Minimum evidence of a higher rectangle around the same place, relative to the lower one."""
MAX_MISSES = 2
"""Number of layers without such a rectangle after which no higher one is searched."""
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
        own = _in_layer(edges, layer)
        near = turns[votes[layer].argmax()] + FINE_TURNS
        angle = float(near[vote_turns(*own, 1, near)[0].argmax()])
        best = _best_rectangle(own, angle)
        if best is not None:
            found.append(_highest(best, edges, layer, angle))
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


def _highest(best: _Rectangle, edges: _Edges, layer: int, angle: float) -> _Rectangle:
    """Return the highest rectangle above one of a layer. The inner faces of walls have edges too.

    Each layer up to it holds a rectangle with nearly as long edges.
    """
    misses, least = 0, MIN_KEPT * best.evidence
    best = best._replace(height=best.height + layer * LAYER / 2)
    while misses <= MAX_MISSES:
        layer += 1
        own = _in_layer(edges, layer)
        higher = _best_rectangle(own, angle) if own.sizes.sum() > MIN_LENGTH else None
        if higher is None or higher.evidence < least:
            misses += 1
            continue
        best, misses = higher._replace(height=higher.height + layer * LAYER / 2), 0
    return best


def _best_rectangle(edges: _Edges, angle: float) -> _Rectangle | None:
    """Return the rectangle of one orientation with the longest edges, or None if all are short.

    Its height is over the lower bound of the layer.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    turned = edges.plan @ np.array([[cos, -sin], [sin, cos]])
    low = turned.min(axis=0)
    x, y = turned[:, 0], turned[:, 1]
    xs, ys = _side_peaks(x, edges.sizes), _side_peaks(y, edges.sizes)
    covered = cover_places(x, y - low[1], xs), cover_places(y, x - low[0], ys)
    (x0, x1, y0, y1), evidence, cover = search_rectangle(xs, ys, covered[0], covered[1], low)
    width, depth = x1 - x0, y1 - y0
    if cover < MIN_WHOLE_COVER or width * depth < MIN_AREA or max(width, depth) > MAX_LENGTH:
        return None
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    corners = corners @ np.array([[cos, sin], [-sin, cos]])
    return _Rectangle(corners, float(np.median(edges.heights)), evidence)


def _side_peaks(values: NDArray[np.float64], sizes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the coordinates (K,) at which the most edges lie, m."""
    low = values.min() - BIN
    cells = ((values - low) / BIN).astype(np.intp)
    votes = np.bincount(cells, weights=sizes, minlength=int(cells.max()) + 2)
    votes[1:] += votes[:-1].copy()
    found = []
    for _ in range(PEAKS):
        peak = int(votes.argmax())
        if votes[peak] <= 0:
            break
        part = (cells == peak) | (cells == peak - 1)
        if part.any():
            found.append(float(np.average(values[part], weights=sizes[part])))
        votes[max(peak - 2, 0) : peak + 3] = 0
    return np.sort(found)


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
    return bool(len(heights) and np.mean(np.abs(heights - rim.height) < LEVEL_BAND) < MAX_LEVEL)


@njit(cache=True, nogil=True)
def vote_turns(plan, heights, sizes, layers, turns):
    """Return the votes (layers, T) for rectangles of T orientations in overlapping layers.

    A vote is the sum of the squared lengths of the edges in each bin across both directions.
    """
    votes = np.zeros((layers, len(turns)))
    length = np.zeros(layers)
    radius = 0.0
    for i in range(len(plan)):
        radius = max(radius, np.hypot(plan[i, 0], plan[i, 1]))
        first = int(heights[i] / (LAYER / 2))
        for layer in range(max(first - 1, 0), min(first + 1, layers)):
            length[layer] += sizes[i]
    bins = int(2 * radius / BIN) + 3
    for t in range(len(turns)):
        cos, sin = np.cos(turns[t]), np.sin(turns[t])
        for axis in range(2):
            lengths = np.zeros((layers, bins))
            for i in range(len(plan)):
                x, y = plan[i, 0], plan[i, 1]
                value = cos * x + sin * y if axis == 0 else cos * y - sin * x
                cell = int((value + radius) / BIN) + 1
                first = int(heights[i] / (LAYER / 2))
                for layer in range(max(first - 1, 0), min(first + 1, layers)):
                    lengths[layer, cell] += sizes[i]
            for layer in range(layers):
                if length[layer] < MIN_LENGTH:
                    continue
                for cell in range(1, bins):
                    votes[layer, t] += (lengths[layer, cell - 1] + lengths[layer, cell]) ** 2
    return votes


@njit(cache=True, nogil=True)
def cover_places(across, along, sides):
    """Count the covered places before each place along each side, (K, places + 1)."""
    places = int(along.max() / PLACE) + 1
    counts = np.zeros((len(sides), places + 1), np.int32)
    for k in range(len(sides)):
        for i in range(len(across)):
            if abs(across[i] - sides[k]) < 1.5 * BIN:
                counts[k, int(along[i] / PLACE) + 1] = 1
        for place in range(places):
            counts[k, place + 1] += counts[k, place]
    return counts


@njit(cache=True, nogil=True)
def search_rectangle(xs, ys, x_covered, y_covered, lows):
    """Return the best bounds (x0, x1, y0, y1), its evidence, m, and its least cover.

    The cover is that of all places or that of the places in the quarters at the corners, whichever
    is less.
    """
    bounds, evidence, cover = (0.0, 0.0, 0.0, 0.0), 0.0, 0.0
    for i in range(len(xs)):
        for j in range(i + 1, len(xs)):
            if xs[j] - xs[i] < MIN_SIDE:
                continue
            a, b = int((xs[i] - lows[0]) / PLACE), int((xs[j] - lows[0]) / PLACE) + 1
            for m in range(len(ys)):
                for n in range(m + 1, len(ys)):
                    if ys[n] - ys[m] < MIN_SIDE:
                        continue
                    c, d = int((ys[m] - lows[1]) / PLACE), int((ys[n] - lows[1]) / PLACE) + 1
                    covered = corner = 0
                    for side in (x_covered[i], x_covered[j]):
                        quarter = (d - c) // 4
                        covered += side[d] - side[c]
                        corner += side[c + quarter] - side[c] + side[d] - side[d - quarter]
                    for side in (y_covered[m], y_covered[n]):
                        quarter = (b - a) // 4
                        covered += side[b] - side[a]
                        corner += side[a + quarter] - side[a] + side[b] - side[b - quarter]
                    whole = 2 * (b - a + d - c)
                    value = PLACE * (covered - MIN_COVER * whole)
                    if value > evidence:
                        quarters = 4 * ((b - a) // 4 + (d - c) // 4)
                        bounds, evidence = (xs[i], xs[j], ys[m], ys[n]), value
                        cover = min(covered / whole, corner / quarters)
    return bounds, evidence, cover

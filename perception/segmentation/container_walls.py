"""Measure the walls of a container around a basin of the depth image."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from .median import median
from .wall_profile import face_distances, inside_polygon, outermost_run, read_strip

MIN_FILL = 0.88
"""Minimum share of its smallest rectangle that a container fills. A round bowl fills 0.79."""
MIN_SIDE = 0.1
"""Minimum inner length of a wall, m."""
PLACE = 0.01
"""Length of the places along a wall at which its rim is measured, m."""
CORNER = 0.02
"""Length at both ends of a wall where its neighbour may be measured instead, m."""
LEVEL_BAND = 0.01
"""Distance from the height of a rim within which a reading may belong to it, m."""
CELL = 0.003
"""Resolution of the profile across a wall, m."""
REACH = 0.05
"""Distance on both sides of the ring at which the wall is measured, m."""
MIN_RIM = 0.008
"""Minimum height of a wall, m: that of the lowest rim, 0.01 m, less its noise."""
TOP_SHARE, TOP_TOLERANCE = 0.15, 0.005
"""Maximum distance of the top of a wall from the common height of its places: as a share of the
height of the wall, and in m. The larger one counts."""
EDGE_SHARE = 0.05
"""Maximum distance of the edge of a rim below its top, as a share of the height of the wall."""
MIN_AGREEING = 0.5
"""Minimum share of the places of a wall whose tops have the common height. Objects around a free
place of a table have different heights, and gaps."""
MAX_EDGE_RESIDUAL = 0.008
"""Maximum distance of a place's rim from the straight rim of the wall, m."""
MAX_SLOPE = 0.2
"""Maximum tangent of the angle between the straight rim of a wall and its side of the rectangle. A
larger one comes from a few places, and two of them may be parallel."""
MIN_THICKNESS, MAX_THICKNESS = 0.003, 0.04
"""Bounds of the thickness of a wall, m."""
FACE_BANDS = 6
"""Bands of height in which the inclination of a wall's inner face is measured."""
MIN_FACE = 0.3
"""Minimum share of the places in which a band of the inner face is visible."""
MAX_DRAFT = 1.0
"""Maximum inclination of a wall, horizontal distance per height."""


class Side(NamedTuple):
    """The rim of one wall in plan, and the inclination of its inner face."""

    start: NDArray[np.float64]
    """A point of the inner edge of the rim, (2,), m."""
    along: NDArray[np.float64]
    """Unit direction of the edge, (2,), counterclockwise around the inside."""
    top: float
    """Height of the rim above the reference plane, m."""
    thickness: float
    """Thickness at the rim, m."""
    draft: float | None
    """Horizontal distance per height by which the face leans outwards. None if it is hidden."""
    seen: bool
    """Whether the rim was measured."""

    @property
    def outwards(self) -> NDArray[np.float64]:
        """Unit normal (2,) away from the inside."""
        return np.array([self.along[1], -self.along[0]])


def ring_rectangle(ring: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the corners (4, 2) around a ring (N, 2) in plan, m, counterclockwise.

    The result is None if the ring is no rectangle, or too small.
    """
    hull = cv2.convexHull(ring.astype(np.float32))
    rectangle = cv2.minAreaRect(hull)
    width, height = rectangle[1]
    if min(width, height) < MIN_SIDE or cv2.contourArea(hull) < MIN_FILL * width * height:
        return None
    corners = cv2.boxPoints(rectangle).astype(np.float64)
    first, second = corners[1] - corners[0], corners[2] - corners[1]
    return corners if first[0] * second[1] > first[1] * second[0] else corners[::-1]


def measure_sides(
    corners: NDArray[np.float64],
    plan: NDArray[np.float64],
    heights: NDArray[np.float64],
    floor: float,
    level: float | None = None,
    visible: NDArray[np.bool_] | None = None,
) -> list[Side]:
    """Measure the walls along the sides of a polygon.

    Parameters
    ----------
    corners
        Corners (K, 2) of the ring in plan, m, counterclockwise.
    plan
        Readings (N, 2) in plan, m, on and around the walls.
    heights
        Their heights (N,) above the reference plane, m.
    floor
        Height of the floor, m.
    level
        Height of the rim above the reference plane, m, if it is known. Readings above it belong to
        the contents.
    visible
        Mask (K, M) of equally spaced places along each side that no content hides and that are in
        the image. Only the part from the first to the last one is measured, and hidden places in it
        count neither for nor against a wall. By default all places are visible.

    Returns
    -------
    list of Side
        One per side. A wall whose rim is not straight, or not in the image, gets the height of the
        others.
    """
    lowest, highest = floor, np.inf
    if level is not None:
        lowest, highest = level - 2 * LEVEL_BAND, level + TOP_TOLERANCE
    if visible is None:
        visible = np.ones((len(corners), 2), bool)
    sides = []
    ends = np.roll(corners, -1, axis=0)
    for start, end, mask in zip(corners, ends, visible, strict=True):
        places = np.flatnonzero(mask)
        # A side without a visible part keeps its direction.
        first, last, share = 0.0, 1.0, 0.0
        if len(places) > 1:
            first, last = places[[0, -1]] / (len(mask) - 1)
            share = len(places) / (places[-1] - places[0] + 1)
        part = start + first * (end - start), start + last * (end - start)
        sides.append(_measure_side(*part, plan, heights, (floor, lowest, highest), share))
    seen = [side for side in sides if side.seen]
    if not seen:
        rising = (heights > floor + MIN_RIM) & (heights <= highest)
        rising = heights[rising & ~inside_polygon(plan, corners, 0.0)]
        top = float(np.median(rising)) if len(rising) else floor
        return [side._replace(top=top, draft=0.0) for side in sides]
    top = float(np.median([side.top for side in seen]))
    thickness = float(np.median([side.thickness for side in seen]))
    drafts = [side.draft for side in seen if side.draft is not None]
    draft = float(np.median(drafts)) if drafts else 0.0
    return [
        side._replace(draft=draft if side.draft is None else side.draft)
        if side.seen
        else side._replace(top=top, thickness=thickness, draft=draft)
        for side in sides
    ]


def _measure_side(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    plan: NDArray[np.float64],
    heights: NDArray[np.float64],
    levels: tuple[float, float, float],
    share: float,
) -> Side:
    """Measure one wall.

    `levels` are the height of the floor, the least height of a rim, and the greatest height of
    readings that count, m. `share` is the share of its places that nothing hides.
    """
    floor, lowest, highest = levels
    length = float(np.linalg.norm(end - start))
    along = (end - start) / max(length, 1e-9)
    outwards = np.array([along[1], -along[0]])
    unseen = Side(start, along, floor, MIN_THICKNESS, None, seen=False)
    if share <= 0 or int((length - 2 * CORNER) / PLACE) < 3:
        return unseen
    side, strip = (start, along, length), (CORNER, REACH, PLACE, CELL)
    readings, place, profile = read_strip(plan, heights, side, (floor + MIN_RIM, highest), strip)
    if not len(readings):
        return unseen
    count = len(profile)
    least = max(MIN_AGREEING * share * count, 3.0)
    tops = profile.max(axis=1)
    risen = tops > lowest
    if np.count_nonzero(risen) < least:
        return unseen
    top = float(np.median(tops[risen]))
    tolerance = max(TOP_SHARE * (top - floor), TOP_TOLERANCE)
    agreeing = risen & (np.abs(tops - top) <= tolerance)
    if np.count_nonzero(agreeing) < least:
        return unseen
    edge_level = top - max(EDGE_SHARE * (top - floor), TOP_TOLERANCE)
    inner, outer = (CELL * edges - REACH for edges in outermost_run(profile, edge_level))
    middles = CORNER + (np.arange(count) + 0.5) * PLACE
    slope, shift = 0.0, float(np.median(inner[agreeing]))
    # A surface that is still high at the end of the profile has its rim farther outside.
    agreeing &= (outer - inner <= MAX_THICKNESS) & (outer <= REACH - 2 * CELL)
    straight = agreeing & (np.abs(inner - shift) <= 2 * MAX_EDGE_RESIDUAL)
    if np.count_nonzero(straight) >= least:
        slope, shift = np.polyfit(middles[straight], inner[straight], 1)
        straight = agreeing & (np.abs(inner - shift - slope * middles) <= MAX_EDGE_RESIDUAL)
    if abs(slope) > MAX_SLOPE or np.count_nonzero(straight) < least:
        return unseen
    thickness = float(np.median((outer - inner)[straight]))
    turned = (along + slope * outwards) / np.hypot(1.0, slope)
    edge = start + shift * outwards
    limits, shape = (CELL, top - TOP_TOLERANCE), (FACE_BANDS, count, floor, top)
    outermost = face_distances(readings, place, (slope, shift), limits, shape)
    return Side(
        edge,
        turned,
        top,
        float(np.clip(thickness, MIN_THICKNESS, MAX_THICKNESS)),
        _draft(outermost, floor, top),
        seen=True,
    )


def _draft(outermost: NDArray[np.float64], floor: float, top: float) -> float | None:
    """Return the inclination of an inner face from the outermost reading of each band and place.

    Objects before the face lie nearer to the inside. The median over the places ignores them.
    """
    levels, distances = [], []
    for number, row in enumerate(outermost):
        visible = row[np.isfinite(row)]
        if len(visible) >= MIN_FACE * len(row):
            levels.append(floor + (number + 0.5) / FACE_BANDS * (top - floor))
            distances.append(float(median(visible)))
    if len(levels) < 3:
        return None
    return float(np.clip(np.polyfit(levels, distances, 1)[0], 0.0, MAX_DRAFT))

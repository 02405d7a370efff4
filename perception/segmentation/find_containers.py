"""Find the containers of a scene, and the supports that their floors are."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..superquadric.ring import find_ring
from .container_walls import MIN_RIM, ring_rectangle
from .enclosed_floor import is_enclosed
from .measure_container import FoundContainer, measure_container
from .rim_rectangles import find_rims, locate
from .support_extent import Support
from .working_image import WorkingImage

MIN_SEEN, MIN_SEEN_AROUND_FLOOR = 0.75, 0.5
"""Minimum share of walls with a straight rim, and the same if the floor between them is visible."""
MAX_DRAFT = 0.5
"""Maximum inclination of a wall around a floor that is not visible, tan of its angle to the
vertical. Heaped bins show up to 0.32; boxes that form a rectangle by chance show 0.9 and more."""
MAX_PLATE = 0.04
"""Maximum height of the rim of a plate, m. A higher round rim may be that of a basket."""
MAX_ROUND = 0.04
"""Maximum deviation of a round rim from its circle over its radius, standard deviation. Plates show
up to 0.017, trays and bins 0.086 and more."""
PLATE_REACH = 1.6
"""Distance from the middle to which the readings of a plate count, in those of its corners."""
RIM_NOISE = 0.0015
"""Expected noise of the readings of a rim, m."""
WALL_MARGIN = 0.01
"""Minimum distance of an object's foot inside the hull of a floor, m, if the rims are not visible.
The walls stand at the hull, and their readings stay."""
SAME_PLANE = 0.01
"""Maximum distance of a floor from a support that is the same plane, m."""
MAX_STEP = 0.25
"""Height of a floor above the first support from which the floor comes first, m. Then the
container stands on something else, and the support is the floor of the room."""


def find_containers(
    image: WorkingImage, supports: list[Support], tops: NDArray[np.float32]
) -> list[FoundContainer]:
    """Find the containers of an image, those with visible rims first.

    The rim of a container is a rectangle at one height, and at least three of its four walls have
    straight rims. The image may also show a floor with rising walls, but not their rims.

    Parameters
    ----------
    image
        The whole image.
    supports
        The supports, at least one. The normal of the first one is up.
    tops
        Heights of the blocks above the first support, from
        :func:`~.block_heights.block_heights`.
    """
    first = supports[0]
    found = []
    for rim in find_rims(tops, image, first.plane):
        one = measure_container(rim.place, rim.corners, image, first.plane, rim.height)
        if _has_walls(one) and not _is_plate(one, image):
            found.append(one)
    if is_enclosed(first, image):
        # Readings of curved walls stay, but outside the floor that is visible.
        inner = first._replace(foot_margin=WALL_MARGIN)
        found = [_on_floor(one, inner) for one in found] or [_around_floor(inner, image)]
    return [
        one._replace(support=one.support._replace(wave=first.wave))
        for one in found
        if one.container.rim >= MIN_RIM
    ]


def _has_walls(one: FoundContainer) -> bool:
    """Return whether enough sides of a rim are walls: straight, and steep around a hidden floor."""
    walls = np.array([wall.seen for wall in one.container.walls])
    if one.container.floor_seen:
        return bool(walls.mean() >= MIN_SEEN_AROUND_FLOOR)
    inclination = one.sides[:, 4]
    return bool((walls & (inclination <= MAX_DRAFT)).mean() >= MIN_SEEN)


def _is_plate(one: FoundContainer, image: WorkingImage) -> bool:
    """Return whether a low rim is round: a plate, which is an object."""
    if one.container.rim > MAX_PLATE:
        return False
    (rows, columns), support = np.nonzero(image.depth[one.window] > 0), one.support
    points = image.points(rows + one.window[0].start, columns + one.window[1].start)
    plan, heights = points @ support.axes.T, support.plane.height(points)
    middle = support.hull.mean(axis=0, dtype=np.float64)
    reach = PLATE_REACH * np.linalg.norm(support.hull - middle, axis=1).max()
    near = (np.linalg.norm(plan - middle, axis=1) < reach) & (heights > one.container.rim / 2)
    ring = find_ring(np.column_stack([plan, heights])[near], middle, RIM_NOISE)
    return ring is not None and bool(
        np.sqrt(np.mean(ring.radial_error() ** 2)) <= MAX_ROUND * ring.semi_axes[0]
    )


def _around_floor(support: Support, image: WorkingImage) -> FoundContainer:
    """Return the container around a floor whose rims are not visible."""
    hull = support.hull.astype(np.float64)
    corners = ring_rectangle(hull)
    if corners is None:
        corners = hull if cv2.contourArea(support.hull, oriented=True) > 0 else hull[::-1]
    place = locate(hull, 0.0, support.plane, image)
    return measure_container(place, corners, image, support.plane)._replace(support=support)


def _on_floor(one: FoundContainer, support: Support) -> FoundContainer:
    """Return a container with a support in place of its floor if both are one plane."""
    apart = abs(one.support.plane.offset - support.plane.offset)
    return one._replace(support=support) if apart <= SAME_PLANE else one


def include_floors(supports: list[Support], found: list[FoundContainer]) -> list[Support]:
    """Return the supports with the floors of the containers among them.

    A floor that lies in the plane of a support extends its hull. What lies flat inside a container
    above its floor is no support.
    """
    for one in found:
        floor = one.support
        outside = [
            support
            for support in supports
            if floor.plane.offset - support.plane.offset <= SAME_PLANE
            or not _lies_in(support, floor)
        ]
        same = [
            number
            for number, support in enumerate(outside)
            if abs(support.plane.offset - floor.plane.offset) <= SAME_PLANE
        ]
        if same and (floor.foot_margin or _lies_in(outside[same[0]], floor)):
            outside[same[0]] = floor
            supports = outside
        elif same:
            support = outside[same[0]]
            corners = floor.hull @ floor.axes @ support.axes.T
            both = np.concatenate([support.hull, corners.astype(np.float32)])
            hull = cv2.convexHull(both).reshape(-1, 2)
            outside[same[0]] = support._replace(hull=hull)
            supports = outside
        elif outside and outside[0].plane.offset - floor.plane.offset <= MAX_STEP:
            supports = [*outside, floor]
        else:
            supports = [floor, *outside]
    return supports


def _lies_in(support: Support, floor: Support) -> bool:
    """Return whether the middle of a support lies over a floor, and its area is smaller."""
    middle = support.hull.mean(axis=0) @ support.axes @ floor.axes.T
    inside = cv2.pointPolygonTest(floor.hull, (float(middle[0]), float(middle[1])), False)
    return inside >= 0 and support.area < floor.area

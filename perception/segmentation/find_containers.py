"""Find the containers of a scene, and the supports that their floors are."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..superquadric.ring import find_ring
from .container_walls import MIN_RIM, ring_rectangle
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

MIN_RISING_SHARE = 0.85
"""Minimum share of the floor's outline beside which a wall rises. The outlines of tables have at
most 0.8, where many things stand at the edge; those of bins have 1."""
MIN_RISE = 0.005
"""Minimum height of a wall within the probed distance, m."""
PROBES = (0.01, 0.02, 0.03)
"""Distances outside the outline at which the image is probed, m."""
MAX_OFFSET = 0.06
"""Maximum distance in plan between a probe and the reading in its pixel, m. A reading farther away
belongs to something behind."""
SPACING = 0.01
"""Distance between the probes along the outline, m."""
MIN_PROBED = 20
"""Minimum number of probes with a reading. An outline that leaves the image has fewer."""
MIN_FACING = 0.3
"""Minimum cosine between the outline's normal and the direction to the camera, in plan, of the
front edge."""
MIN_FRONT = 0.5
"""Minimum share of the front edge that the image contains. Boards have walls on the other three
sides."""


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


def is_enclosed(support: Support, image: WorkingImage) -> bool:
    """Return whether a wall rises beside nearly the whole outline of a support.

    The outline is probed at places beside it. A wall rises there if the reading in the pixel of a
    probe is above the support and near the probe in plan.
    """
    places, outwards = _outline(support.hull.astype(np.float64))
    # The camera is at the origin of the plan.
    towards = -np.einsum("ij,ij->i", places, outwards) / np.linalg.norm(places, axis=1)
    front = towards > MIN_FACING
    visible = front.copy()
    plane, k = support.plane, image.intrinsics
    rows, columns = image.depth.shape
    rises = np.zeros(len(places), bool)
    probed = np.zeros(len(places), bool)
    for distance in PROBES:
        plan = places + distance * outwards
        points = plan @ support.axes - plane.offset * plane.normal
        z = np.maximum(points[:, 2], 1e-6)
        u = np.rint(points[:, 0] / z * k.fx + k.cx)
        v = np.rint(points[:, 1] / z * k.fy + k.cy)
        inside = (points[:, 2] > 0) & (u >= 0) & (v >= 0) & (u < columns) & (v < rows)
        visible &= inside
        u = np.where(inside, u, 0).astype(np.intp)
        v = np.where(inside, v, 0).astype(np.intp)
        depth = np.where(inside, image.depth[v, u], 0.0).astype(np.float64)
        reading = np.column_stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(len(u))])
        reading *= depth[:, None]
        near = np.linalg.norm(reading @ support.axes.T - plan, axis=1) < MAX_OFFSET
        probed |= depth > 0
        rises |= (depth > 0) & near & (plane.height(reading) > MIN_RISE)
    if visible.sum() < MIN_FRONT * front.sum():
        return False
    count = int(np.count_nonzero(probed))
    return bool(count >= MIN_PROBED and np.count_nonzero(rises) >= MIN_RISING_SHARE * count)


def _outline(hull: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places along a hull (K, 2), (N, 2) m, and the outward unit normals there (N, 2)."""
    following = np.roll(hull, -1, axis=0)
    edges = following - hull
    lengths = np.linalg.norm(edges, axis=1)
    counts = np.maximum((lengths / SPACING).astype(np.intp), 1)
    side = np.repeat(np.arange(len(hull)), counts)
    along = np.concatenate([(np.arange(count) + 0.5) / count for count in counts])
    places = hull[side] + along[:, None] * edges[side]
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.maximum(lengths, 1e-9)[:, None]
    inwards = np.einsum("ij,ij->i", normals, hull - hull.mean(axis=0)) < 0
    normals[inwards] *= -1.0
    return places, normals[side]

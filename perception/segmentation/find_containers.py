"""Find the containers of a scene: measure the walls around each basin of the depth image."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numba import njit

from ..perpendicular import perpendicular_pair
from .above_support import BAND_WAVES, MIN_HEIGHT, SUPPORT_SIGMAS
from .basins import Basin, find_basins
from .container import Container, Wall
from .container_walls import MIN_RIM, REACH, Side, depth_inside, measure_sides, ring_rectangle
from .enclosed_floor import is_enclosed
from .result import SupportPlane
from .support_extent import Support

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .working_image import WorkingImage

MEASURED_PIXELS = 60000
"""Pixels around a basin on which its walls are measured. More take longer."""
MAX_LENGTH = 1.3
"""Maximum length of a container, m. Larger ones are rooms."""
MIN_SEEN = 0.75
"""Minimum share of walls with a straight rim around a basin."""
LOWEST_SHARE = 0.01
"""Share of the readings inside a container that may lie below its floor: outliers."""
MIN_FLOOR = 0.004
"""Minimum visible area of a floor, m². Less may be the flat top of something in a heap."""
FLOOR_OPENING = 5
"""Side of the window that a visible part of a floor fills, px of the measured image."""
MIN_BAND = 0.003
"""Minimum half width of the band around a floor or a wall, m."""
WALL_BAND = 0.006
"""Distance inside and above a wall within which readings belong to it, m: the error of its
measured faces."""
OUTER_MARGIN = 0.012
"""Distance outside a wall up to which readings below its rim belong to it, m."""
WALL_MARGIN = 0.01
"""Minimum distance of an object's foot inside the hull of a floor, m, if the rims are not visible.
The walls stand at the hull, and their readings stay."""
SAME_PLANE = 0.01
"""Maximum distance of a floor from a support that is the same plane, m."""
MAX_STEP = 0.25
"""Height of a floor above the first support from which the floor comes first, m. Then the
container stands on something else, and the support is the floor of the room."""


class FoundContainer(NamedTuple):
    """A container with what the stages need of it."""

    container: Container
    """The container, camera frame."""
    sides: NDArray[np.float64]
    """Inner faces and tops of its walls (K, 6): unit outward normal in plan; offset of the inner
    edge of the rim along it, m; height of the rim above the floor, m; inclination; thickness, m.
    The height is -inf where no rim was measured."""
    support: Support
    """Its floor with the hull of its outer edges."""
    window: tuple[slice, slice]
    """Rows and columns of the image around it."""


class _Readings(NamedTuple):
    """The measured readings around a basin."""

    plan: NDArray[np.float64]
    """Plan coordinates (N, 2), m."""
    heights: NDArray[np.float64]
    """Heights (N,) above the reference plane, m."""
    pixels: NDArray[np.intp]
    """Rows and columns (N, 2) in the reduced window."""
    within: NDArray[np.bool_]
    """Which of them (N,) lie within the basin in the image."""
    area: NDArray[np.float64]
    """Area (N,) of each pixel in plan, m²."""
    shape: tuple[int, int]
    """Rows and columns of the reduced window."""


def find_containers(
    image: WorkingImage, supports: list[Support], tops: NDArray[np.float32]
) -> list[FoundContainer]:
    """Find the containers of an image, those with visible rims first.

    The rim of a container encloses a basin of the image, and at least three of its four walls have
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
    plane = supports[0].plane
    found = []
    for basin in find_basins(tops, image, plane):
        corners = ring_rectangle(basin.ring @ perpendicular_pair(plane.normal).T)
        if corners is not None and np.ptp(corners, axis=0).max() < MAX_LENGTH:
            one = _measure(basin, corners, image, plane)
            if np.mean([wall.seen for wall in one.container.walls]) >= MIN_SEEN:
                found.append(one)
    if not found and is_enclosed(supports[0], image):
        basin, corners = _floor_basin(supports[0], image)
        one = _measure(basin, corners, image, plane)
        found.append(one._replace(support=supports[0]._replace(foot_margin=WALL_MARGIN)))
    wave = supports[0].wave
    return [
        one._replace(support=one.support._replace(wave=wave))
        for one in found
        if one.container.rim >= MIN_RIM
    ]


def _floor_basin(support: Support, image: WorkingImage) -> tuple[Basin, NDArray[np.float64]]:
    """Return the floor of a container as a basin, and its corners (K, 2) in plan, m."""
    hull = support.hull.astype(np.float64)
    corners = ring_rectangle(hull)
    if corners is None:
        corners = hull if cv2.contourArea(support.hull, oriented=True) > 0 else hull[::-1]
    points = hull @ support.axes - support.plane.offset * support.plane.normal
    pixels = image.intrinsics.project(points).astype(np.float32)
    low, high = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0)) + 1
    low = np.maximum(low, 0).astype(int)
    window = (
        slice(low[1], max(int(high[1]), low[1] + 1)),
        slice(low[0], max(int(high[0]), low[0] + 1)),
    )
    return Basin(window, pixels, points), corners


def _measure(
    basin: Basin, corners: NDArray[np.float64], image: WorkingImage, plane: SupportPlane
) -> FoundContainer:
    """Measure the floor and the walls along the sides of a polygon in plan (K, 2), m."""
    axes = perpendicular_pair(plane.normal)
    window = _widened(basin, image)
    readings = _read(image, window, basin.outline, plane, axes)
    inside = readings.within & (depth_inside(readings.plan, corners) > REACH / 2)
    floor, tolerance, seen = _find_floor(readings, inside, plane)
    sides = measure_sides(corners, readings.plan, readings.heights, floor)
    floor_plane = SupportPlane(plane.normal, plane.offset - floor, tolerance)
    tops = np.array([side.top for side in sides]) - floor
    walls = _walls(sides, floor_plane, axes, floor)
    container = Container(floor_plane, walls, float(np.median(tops)), seen)
    outer = _corners(sides, [side.thickness for side in sides])
    depth = float(np.median(basin.ring[:, 2]))
    area = float(cv2.contourArea(outer.astype(np.float32)))
    hull = outer.astype(np.float32)
    support = Support(floor_plane, hull, axes, depth, area, foot_margin=0.0)
    return FoundContainer(container, _side_table(sides, floor), support, window)


def _side_table(sides: list[Side], floor: float) -> NDArray[np.float64]:
    """Return the rows of `FoundContainer.sides`."""
    return np.array(
        [
            [
                *side.outwards,
                side.outwards @ side.start,
                side.top - floor if side.seen else -np.inf,
                (side.draft or 0.0) if side.seen else 0.0,
                side.thickness,
            ]
            for side in sides
        ]
    )


def _widened(basin: Basin, image: WorkingImage) -> tuple[slice, slice]:
    """Return the window of a basin, widened by the reach of its walls."""
    rows, columns = basin.window
    margin = int(2 * REACH * image.intrinsics.fx / max(float(basin.ring[:, 2].min()), 0.1))
    height, width = image.depth.shape
    return (
        slice(max(rows.start - margin, 0), min(rows.stop + margin, height)),
        slice(max(columns.start - margin, 0), min(columns.stop + margin, width)),
    )


def _read(
    image: WorkingImage,
    window: tuple[slice, slice],
    outline: NDArray[np.float32],
    plane: SupportPlane,
    axes: NDArray[np.float64],
) -> _Readings:
    rows, columns = window
    count = (rows.stop - rows.start) * (columns.stop - columns.start)
    step = max(round(np.sqrt(count / MEASURED_PIXELS)), 1)
    depth = image.depth[rows.start : rows.stop : step, columns.start : columns.stop : step]
    v, u = np.nonzero(depth)
    z = depth[v, u].astype(np.float64)
    k = image.intrinsics
    rays = np.ones((len(u), 3))
    rays[:, 0] = (u * step + columns.start - k.cx) / k.fx
    rays[:, 1] = (v * step + rows.start - k.cy) / k.fy
    points = rays * z[:, None]
    within = np.zeros(depth.shape, np.uint8)
    corners = (outline - [columns.start, rows.start]) / step
    cv2.fillConvexPoly(within, np.rint(corners).astype(np.int32), 1)
    area = step**2 * z**2 / (k.fx * k.fy * np.maximum(-(rays @ plane.normal), 0.1))
    return _Readings(
        points @ axes.T,
        plane.height(points),
        np.column_stack([v, u]),
        within[v, u] > 0,
        area,
        depth.shape,
    )


def _find_floor(
    readings: _Readings, inside: NDArray[np.bool_], plane: SupportPlane
) -> tuple[float, float, bool]:
    """Return the height of the floor, its tolerance, m, and whether it is visible.

    The floor is the lowest flat part. Without one, the lowest reading is its height.
    """
    heights = readings.heights[inside]
    if not len(heights):
        return 0.0, plane.tolerance, False
    lowest = float(np.quantile(heights, LOWEST_SHARE))
    band = max(SUPPORT_SIGMAS * plane.tolerance, MIN_BAND)
    level = inside & (np.abs(readings.heights - lowest) <= 2 * band)
    level = inside & (np.abs(readings.heights - np.median(readings.heights[level])) <= band)
    mask = np.zeros(readings.shape, np.uint8)
    mask[tuple(readings.pixels[level].T)] = 1
    flat = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((FLOOR_OPENING,) * 2, np.uint8))
    flat = level & (flat[tuple(readings.pixels.T)] > 0)
    if readings.area[flat].sum() < MIN_FLOOR:
        return lowest, plane.tolerance, False
    return float(np.median(readings.heights[flat])), plane.tolerance, True


def _corners(sides: list[Side], shifts: list[float]) -> NDArray[np.float64]:
    """Return the corners (K, 2) between the sides, each shifted outwards, m.

    Corner k lies between side k-1 and side k.
    """
    normals = np.array([side.outwards for side in sides])
    offsets = np.array([side.outwards @ side.start for side in sides]) + shifts
    return np.array(
        [np.linalg.solve(normals[[k - 1, k]], offsets[[k - 1, k]]) for k in range(len(sides))],
        np.float64,
    )


def _walls(
    sides: list[Side], plane: SupportPlane, axes: NDArray[np.float64], floor: float
) -> tuple[Wall, ...]:
    """Return the walls between the corners at the floor and at the rim."""
    shifts = [-(side.draft or 0.0) * (side.top - floor) for side in sides]
    foot = _corners(sides, shifts) @ axes - plane.offset * plane.normal
    edge = _corners(sides, [0.0] * len(sides)) @ axes - plane.offset * plane.normal
    walls = []
    for k, side in enumerate(sides):
        following = (k + 1) % len(sides)
        up = (side.top - floor) * plane.normal
        corners = np.array([foot[k], foot[following], edge[following] + up, edge[k] + up])
        walls.append(Wall(corners, side.thickness, side.seen))
    return tuple(walls)


def remove_walls(
    above: NDArray[np.bool_], image: WorkingImage, found: FoundContainer
) -> NDArray[np.bool_]:
    """Return the candidates (H, W) without the walls and the floor of a container."""
    rows, columns = found.window
    k = image.intrinsics.cropped(rows, columns)
    rays = (np.arange(k.width) - k.cx) / k.fx, (np.arange(k.height) - k.cy) / k.fy
    plane, depth = found.container.floor, np.ascontiguousarray(image.depth[found.window])
    axes = np.vstack([plane.normal, found.support.axes])
    spread = max(
        SUPPORT_SIGMAS * plane.tolerance / max(found.support.depth, 1e-6) ** 2,
        BAND_WAVES * found.support.wave,
    )
    kept = above.copy()
    part = np.ascontiguousarray(above[found.window])
    unmark_walls(part, depth, rays, (axes, plane.offset, spread), found.sides)
    kept[found.window] = part
    return kept


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


@njit(cache=True, nogil=True)
def unmark_walls(above, depth, rays, frame, sides):
    """Unmark the readings (H, W) at the walls, up to their rims, and on the floor between them."""
    rows, columns = depth.shape
    rays_u, rays_v = rays
    axes, offset, spread = frame
    for v in range(rows):
        for u in range(columns):
            z = np.float64(depth[v, u])
            if z <= 0 or not above[v, u]:
                continue
            height = z * (axes[0, 0] * rays_u[u] + axes[0, 1] * rays_v[v] + axes[0, 2]) + offset
            x = z * (axes[1, 0] * rays_u[u] + axes[1, 1] * rays_v[v] + axes[1, 2])
            y = z * (axes[2, 0] * rays_u[u] + axes[2, 1] * rays_v[v] + axes[2, 2])
            band = max(spread * z * z, WALL_BAND)
            floor_band = max(spread * z * z, MIN_HEIGHT)
            in_wall, inside, within = False, True, True
            for k in range(len(sides)):
                face = sides[k, 2]
                if sides[k, 4] > 0:
                    face += sides[k, 4] * (height - sides[k, 3])
                behind = sides[k, 0] * x + sides[k, 1] * y - face
                inside = inside and behind < 0
                within = within and behind < sides[k, 5] + OUTER_MARGIN
                in_wall = in_wall or (behind > -band and height < sides[k, 3] + band)
            if (within and in_wall) or (inside and height < floor_band):
                above[v, u] = False

"""Measure a container: the floor, and the walls around it."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .above_support import SUPPORT_SIGMAS
from .container import Container, Wall
from .container_walls import REACH, Side, measure_sides
from .median import median
from .result import SupportPlane
from .rim_rectangles import RimPlace
from .rim_votes import count_visible
from .support_extent import Support
from .wall_profile import inside_polygon, read_window
from .working_image import WorkingImage

MEASURED_PIXELS = 60000
"""Pixels around a rim on which its walls are measured. More take longer."""
LOWEST_SHARE = 0.01
"""Share of the readings inside a container that may lie below its floor: outliers."""
MIN_FLOOR = 0.004
"""Minimum visible area of a floor, m². Less may be the flat top of something in a heap."""
FLOOR_OPENING = 5
"""Side of the window that a visible part of a floor fills, px of the measured image."""
SIDE_SAMPLES = 65
"""Places along a side that are looked up in the image."""
MIN_BAND = 0.003
"""Minimum half width of the band around a floor or a wall, m."""


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
    """The measured readings around a container."""

    plan: NDArray[np.float64]
    """Plan coordinates (N, 2), m."""
    heights: NDArray[np.float64]
    """Heights (N,) above the reference plane, m."""
    areas: NDArray[np.float64]
    """Areas (N,) of their pixels in plan, m²."""
    pixels: NDArray[np.intp]
    """Their flat pixels (N,) in `within`."""
    within: NDArray[np.uint8]
    """1 where a pixel (H, W) of the reduced window lies within the rim in the image."""


def measure_container(
    place: RimPlace,
    corners: NDArray[np.float64],
    image: WorkingImage,
    plane: SupportPlane,
    level: float | None = None,
) -> FoundContainer:
    """Measure the floor and the walls of a container.

    Parameters
    ----------
    place
        The place of its rim, or of its floor, in the image.
    corners
        Corners (K, 2) of the rim, or of the floor, in plan, m, counterclockwise.
    image
        The whole image.
    plane
        A plane of any offset. Its normal is up.
    level
        Height of the rim above the plane, m, if it is known. Contents may be higher.
    """
    axes = perpendicular_pair(plane.normal)
    window = _widened(place, image)
    readings = _read(image, window, place.outline, plane, axes)
    inside = inside_polygon(readings.plan, corners, REACH / 2)
    inside &= readings.within.ravel()[readings.pixels] > 0
    floor, tolerance, seen = _find_floor(readings, inside, plane)
    visible = None if level is None else _visible_places(place.ring, image)
    sides = measure_sides(corners, readings.plan, readings.heights, floor, level, visible)
    floor_plane = SupportPlane(plane.normal, plane.offset - floor, tolerance)
    tops = np.array([side.top for side in sides]) - floor
    walls = _walls(sides, floor_plane, axes, floor)
    container = Container(floor_plane, walls, float(np.median(tops)), seen)
    outer = _corners(sides, [side.thickness for side in sides])
    depth = float(np.median(place.ring[:, 2]))
    area = float(cv2.contourArea(outer.astype(np.float32)))
    hull = outer.astype(np.float32)
    support = Support(floor_plane, hull, axes, depth, area, foot_margin=0.0)
    return FoundContainer(container, _side_table(sides, floor), support, window)


def _visible_places(ring: NDArray[np.float64], image: WorkingImage) -> NDArray[np.bool_]:
    """Return a mask (K, SIDE_SAMPLES) of the visible places along each side of a ring (K, 3)."""
    directions = np.roll(ring, -1, axis=0) - ring
    shares = np.linspace(0.0, 1.0, SIDE_SAMPLES)
    counts = [
        count_visible(start[None], shares, direction, image.pinhole, image.depth)[0, :, 1]
        for start, direction in zip(ring, directions, strict=True)
    ]
    return np.diff(np.array(counts), axis=1) > 0


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


def _widened(place: RimPlace, image: WorkingImage) -> tuple[slice, slice]:
    """Return the window of a rim, widened by the reach of its walls."""
    rows, columns = place.window
    margin = int(2 * REACH * image.intrinsics.fx / max(float(place.ring[:, 2].min()), 0.1))
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
    k = image.intrinsics
    rays = (
        (np.arange(depth.shape[1]) * step + columns.start - k.cx) / k.fx,
        (np.arange(depth.shape[0]) * step + rows.start - k.cy) / k.fy,
    )
    frame = np.vstack([plane.normal, axes])
    read = read_window(depth, rays, frame, plane.offset, step**2 / (k.fx * k.fy))
    within = np.zeros(depth.shape, np.uint8)
    corners = (outline - [columns.start, rows.start]) / step
    cv2.fillConvexPoly(within, np.rint(corners).astype(np.int32), 1)
    return _Readings(*read, within)


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
    middle = median(heights[np.abs(heights - lowest) <= 2 * band])
    level = np.abs(heights - middle) <= band
    heights, pixels = heights[level], readings.pixels[inside][level]
    mask = np.zeros(readings.within.shape, np.uint8)
    mask.ravel()[pixels] = 1
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((FLOOR_OPENING,) * 2, np.uint8))
    flat = mask.ravel()[pixels] > 0
    if readings.areas[inside][level][flat].sum() < MIN_FLOOR:
        return lowest, plane.tolerance, False
    return float(median(heights[flat])), plane.tolerance, True


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

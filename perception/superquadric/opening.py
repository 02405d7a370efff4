"""Detect the opening of a vessel in the cloud of one view: a rim with a low middle."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np

from ..perpendicular import perpendicular_pair
from .vessel import Rim

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

SECTORS = 24
"""Sectors about the middle of the rim in which the highest points are searched."""
SECTOR_RANK = 2
"""The rim in a sector is its second highest point. The highest one has the most noise."""
ROUNDS = 2
"""Rounds in which rim and sectors follow each other. More rounds move the middle below 1 mm."""
TRIMS = 2
TRIM_RATIO = 3.0
"""Points of the rim farther away than so many times the median do not count."""
TOP_BAND = 0.15
"""Share of the height of the cloud below its top from which the first middle is computed."""
MIN_SECTORS = 0.75
"""Minimum share of the sectors that show the rim."""
MAX_RIM_SPREAD = 0.06
"""Maximum deviation of the rim from its ellipse over its mean radius, standard deviation. The
nearer rim shows the outer edge, the farther one the inner edge. A square deviates by 0.1."""
MAX_RIM_HEIGHT = 0.05
"""Maximum deviation of the rim from its plane over its diameter, standard deviation."""
MAX_TILT = 0.35
"""Maximum angle of the rim from the first direction, rad."""
MIN_VIEW_SINE = 0.09
"""Sine of the elevation of the camera above the plane of the rim below which the inside is not
seen."""
MIN_DEPTH = 0.12
"""Minimum depth of a vessel below its rim over its diameter. A plate has less."""
MIN_DEPTH_NOISE = 6.0
"""Minimum depth in expected noise."""
INNER_SHARE = 0.8
"""Share of the semi-axes of the rim within which all rays must enter the vessel."""
MIN_ENTERED = 0.75
"""Minimum share of the readings through this inner ellipse that lie below the rim."""
CELLS = 7
"""Cells across the inner ellipse in which readings are searched."""
MIN_CELLS = 0.85
"""Minimum share of cells with a reading on the object. Through a ring the support is seen."""
MAX_ASPECT = 2.0
"""Maximum ratio of the semi-axes of a rim."""
ELLIPSE_GAIN = 2.0
"""Ratio of the mean squares about circle and ellipse from which on the rim is an ellipse. It pays
for two parameters of 24 sectors under strong evidence."""


class Opening(NamedTuple):
    """The opening of a vessel and the points that lie in it."""

    rim: Rim
    """The rim in the frame of the cloud."""
    inside: NDArray[np.bool_]
    """(N,) whether each point lies inside: its ray crosses the plane within the rim."""
    lid: NDArray[np.float64]
    """(K, 3) intersections of the rays of these points with the plane of the rim, m."""


class _Frame(NamedTuple):
    """Coordinates in which the opening direction is z."""

    axes: NDArray[np.float64]
    """Side, side and opening direction as rows, (3, 3)."""
    local: NDArray[np.float64]
    """(N, 3) points, m."""
    eye: NDArray[np.float64]
    """(3,) camera, m."""


class _Ring(NamedTuple):
    """Highest points around a middle."""

    points: NDArray[np.float64]
    """(S, 3) highest points of the sectors that show the rim, m."""
    middle: NDArray[np.float64]
    """(2,) middle of the ellipse, m."""
    semi_axes: NDArray[np.float64]
    """(2,) m."""
    angle: float
    """Angle of the first semi-axis, rad."""
    plane: NDArray[np.float64]
    """(3,) slopes and offset of the plane z = a x + b y + c."""


def find_opening(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
    directions: Iterable[NDArray[np.float64]],
    noise: float,
) -> Opening | None:
    """Return the opening of a vessel; None if the cloud shows none.

    The highest points along a direction must form an ellipse all around. The rays through this
    ellipse must end clearly below it, and on the object.

    Parameters
    ----------
    points
        (N, 3) points of the object, m.
    view_origin
        (3,) position of the camera, m.
    directions
        Unit vectors (3,) near which the opening may point. The first one with an opening counts.
    noise
        Expected noise of the points, m.
    """
    for direction in directions:
        opening = _find_along(points, view_origin, direction, noise)
        if opening is not None:
            return opening
    return None


def _find_along(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    noise: float,
) -> Opening | None:
    frame = _frame(points, view_origin, direction)
    if frame.eye[2] <= frame.local[:, 2].max():
        return None
    middle = _first_middle(frame.local)
    ring = _ring(frame.local, middle, noise)
    for _ in range(ROUNDS):
        if ring is None:
            return None
        frame, middle = _levelled(frame, ring, points, view_origin)
        if frame.axes[2] @ direction < np.cos(MAX_TILT):
            return None
        ring = _ring(frame.local, middle, noise)
    if ring is None:
        return None
    ring = _with_ellipse(ring)
    if not _is_ring(ring, noise):
        return None
    return _entered(frame, ring, noise)


def _frame(
    points: NDArray[np.float64], view_origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> _Frame:
    axes = np.array([*perpendicular_pair(direction), direction])
    return _Frame(axes, points @ axes.T, axes @ view_origin)


def _first_middle(local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the middle (2,) of the highest points."""
    low, high = np.quantile(local[:, 2], [0.02, 0.98])
    upper = local[local[:, 2] > high - TOP_BAND * (high - low), :2]
    middle, _ = cv2.minEnclosingCircle(upper.astype(np.float32))
    return np.array(middle, dtype=np.float64)


def _ring(local: NDArray[np.float64], middle: NDArray[np.float64], noise: float) -> _Ring | None:
    """Return the highest points of the sectors about a middle (2,), and their circle.

    A sector may miss the rim, because the search for outliers drops thin strips. Points far from
    the plane or the circle of the others do not count.
    """
    offset = local[:, :2] - middle
    sector = np.floor((np.arctan2(offset[:, 1], offset[:, 0]) / (2 * np.pi) + 0.5) * SECTORS)
    order = np.lexsort((-local[:, 2], sector))
    _, first, counts = np.unique(sector[order], return_index=True, return_counts=True)
    highest = local[order[first[counts >= SECTOR_RANK] + SECTOR_RANK - 1]]
    if len(highest) < MIN_SECTORS * SECTORS:
        return None
    ring = _circle(highest)
    for _ in range(TRIMS):
        error = np.hypot(_radial_error(ring, highest), _height_error(ring, highest))
        kept = error <= TRIM_RATIO * float(np.median(error)) + noise
        ring = _circle(highest[kept])
    return ring if len(ring.points) >= MIN_SECTORS * SECTORS else None


def _circle(highest: NDArray[np.float64]) -> _Ring:
    """Return the circle and the plane through points (S, 3) with the least squares."""
    x, y, z = highest.T
    rows = np.column_stack([x, y, np.ones_like(x)])
    targets = np.column_stack([x**2 + y**2, z])
    solution, plane = np.linalg.lstsq(rows, targets, rcond=None)[0].T
    middle = 0.5 * solution[:2]
    radius = float(np.sqrt(max(solution[2] + middle @ middle, 0.0)))
    return _Ring(highest, middle, np.array([radius, radius]), 0.0, plane)


def _with_ellipse(circle: _Ring) -> _Ring:
    """Return a ring with an ellipse if that is clearly closer than its circle."""
    flat = circle.points[:, :2]
    (x, y), (first, second), degrees = cv2.fitEllipseDirect((1e3 * flat).astype(np.float32))
    semi_axes, angle = 0.5e-3 * np.array([first, second]), float(np.radians(degrees))
    if second > first:
        semi_axes, angle = semi_axes[::-1], angle + np.pi / 2
    if not (np.all(np.isfinite(semi_axes)) and semi_axes[1] > 0):
        return circle
    ellipse = circle._replace(middle=1e-3 * np.array([x, y]), semi_axes=semi_axes, angle=angle)
    gain = np.mean(_radial_error(circle, circle.points) ** 2) / max(
        np.mean(_radial_error(ellipse, circle.points) ** 2), 1e-12
    )
    return ellipse if gain > ELLIPSE_GAIN else circle


def _radial_error(ring: _Ring, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distances (S,) of points (S, 3) from the ellipse along their rays, m."""
    scale = _ellipse_scale(ring, points[:, :2])
    radius = np.linalg.norm(points[:, :2] - ring.middle, axis=1)
    return radius * (1.0 - 1.0 / np.maximum(scale, 1e-9))


def _height_error(ring: _Ring, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the heights (S,) of points (S, 3) above the plane of the ring, m."""
    return points[:, 2] - points[:, :2] @ ring.plane[:2] - ring.plane[2]


def _ellipse_scale(ring: _Ring, flat: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the scale (N,) of the ellipse about its middle that touches points (N, 2)."""
    c, s = np.cos(ring.angle), np.sin(ring.angle)
    return np.linalg.norm(
        (flat - ring.middle) @ np.array([[c, -s], [s, c]]) / ring.semi_axes, axis=1
    )


def _levelled(
    frame: _Frame,
    ring: _Ring,
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
) -> tuple[_Frame, NDArray[np.float64]]:
    """Return the frame with the normal of the ring's plane as z, and the middle in it."""
    slope_x, slope_y, offset = ring.plane
    normal = np.array([-slope_x, -slope_y, 1.0]) @ frame.axes
    levelled = _frame(points, view_origin, normal / np.linalg.norm(normal))
    middle = np.append(ring.middle, ring.plane[:2] @ ring.middle + offset) @ frame.axes
    return levelled, levelled.axes[:2] @ middle


def _is_ring(ring: _Ring, noise: float) -> bool:
    """Return whether the highest points form a level ellipse."""
    radius = float(np.mean(ring.semi_axes))
    spread = float(np.sqrt(np.mean(_radial_error(ring, ring.points) ** 2)))
    level = float(np.std(ring.points[:, 2]))
    return (
        ring.semi_axes[0] <= MAX_ASPECT * ring.semi_axes[1]
        and spread <= MAX_RIM_SPREAD * radius + noise
        and level <= MAX_RIM_HEIGHT * radius + noise
    )


def _entered(frame: _Frame, ring: _Ring, noise: float) -> Opening | None:
    """Return the opening if the rays through the ring end below it."""
    height = float(np.median(ring.points[:, 2]))
    radius = float(np.mean(ring.semi_axes))
    local, eye = frame.local, frame.eye
    rise = eye[2] - height
    away = float(np.linalg.norm(eye - np.append(ring.middle, height)))
    if rise < MIN_VIEW_SINE * away:
        return None
    crossing = (
        eye[:2]
        + (local[:, :2] - eye[:2]) * (rise / np.maximum(eye[2] - local[:, 2], 1e-9))[:, None]
    )
    scale = _ellipse_scale(ring, crossing)
    below = height - local[:, 2]
    tolerance = 2.0 * noise
    inner = scale < INNER_SHARE
    if np.count_nonzero(inner) == 0 or not _fills(ring, crossing[inner]):
        return None
    depth = float(np.quantile(below[inner], 0.9))
    if depth < max(2.0 * MIN_DEPTH * radius, MIN_DEPTH_NOISE * noise):
        return None
    if np.mean(below[inner] > tolerance) < MIN_ENTERED:
        return None
    inside = (scale < 1.0) & (below > tolerance)
    lid = np.column_stack([crossing[inside], np.full(np.count_nonzero(inside), height)])
    c, s = np.cos(ring.angle), np.sin(ring.angle)
    rim = Rim(
        centre=np.append(ring.middle, height) @ frame.axes,
        semi_axes=ring.semi_axes,
        directions=np.array([[c, s, 0.0], [-s, c, 0.0]]) @ frame.axes,
    )
    return Opening(rim, inside, lid @ frame.axes)


def _fills(ring: _Ring, crossing: NDArray[np.float64]) -> bool:
    """Return whether crossings (K, 2) fill the inner ellipse."""
    c, s = np.cos(ring.angle), np.sin(ring.angle)
    unit = (crossing - ring.middle) @ np.array([[c, -s], [s, c]]) / (INNER_SHARE * ring.semi_axes)
    cells = np.clip(((unit + 1.0) / 2.0 * CELLS).astype(int), 0, CELLS - 1)
    middles = (np.arange(CELLS) + 0.5) / CELLS * 2.0 - 1.0
    in_ellipse = np.hypot(*np.meshgrid(middles, middles)) < 1.0
    filled = np.zeros((CELLS, CELLS), dtype=bool)
    filled[cells[:, 1], cells[:, 0]] = True
    return bool(np.mean(filled[in_ellipse]) >= MIN_CELLS)

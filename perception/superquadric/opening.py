"""Detect the opening of a vessel in the cloud of one view: a rim with a low middle."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..perpendicular import perpendicular_pair
from .ring import Ring, find_ring, with_ellipse
from .vessel import Rim

ROUNDS = 2
"""Rounds in which rim and sectors follow each other. More rounds move the middle below 1 mm."""
TOP_BAND = 0.15
"""Share of the height of the cloud below its top from which the first middle is computed."""
MAX_TILT = 0.35
"""Maximum angle of the rim from the first direction, rad."""
MIN_VIEW_SINE = 0.09
"""Sine of the elevation of the camera above the plane of the rim below which the inside is not
seen."""
MIN_DEPTH = 0.12
"""Minimum depth of a vessel below its rim over its diameter. A plate has less."""
MIN_DEPTH_NOISE = 6.0
"""Minimum depth in expected noise."""
INNER_SHARES = (0.8, 0.6, 0.45)
"""Shares of the semi-axes of the rim within which all rays must enter the vessel: the first one
that shows an opening counts. A thick wall leaves a narrow one."""
MIN_ENTERED = 0.75
"""Minimum share of the readings through this inner ellipse that lie below the rim."""
CELLS = 7
"""Cells across the inner ellipse in which readings are searched."""
MIN_CELLS = 0.6
"""Minimum share of cells with a reading on the object, or through a ring on other surfaces. Between
these surfaces readings are left out."""


class Opening(NamedTuple):
    """The opening of a vessel and the points that lie in it."""

    rim: Rim
    """The rim in the frame of the cloud."""
    inside: NDArray[np.bool_]
    """(N,) whether each point lies inside: its ray crosses the plane within the rim."""
    lid: NDArray[np.float64]
    """(K, 3) intersections of the rays of these points with the plane of the rim, m."""
    inner_share: float
    """Share of the semi-axes of the rim within which all rays enter."""
    seen_through: NDArray[np.float64]
    """(M, 3) points on other surfaces whose rays pass within this share, m."""
    seen_lid: NDArray[np.float64]
    """(M, 3) intersections of these rays with the plane of the rim, m."""
    through_share: float
    """Share of the cells of the inner ellipse in which these points are seen, 0-1."""


class _Frame(NamedTuple):
    """Coordinates in which the opening direction is z."""

    axes: NDArray[np.float64]
    """Side, side and opening direction as rows, (3, 3)."""
    local: NDArray[np.float64]
    """(N, 3) points, m."""
    eye: NDArray[np.float64]
    """(3,) camera, m."""


def find_opening(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
    directions: Iterable[NDArray[np.float64]],
    noise: float,
    beyond: NDArray[np.float64] | None = None,
) -> Opening | None:
    """Return the opening of a vessel or ring; None if the cloud shows none.

    The highest points along a direction must form an ellipse all around. The rays through this
    ellipse must end clearly below it, on the object or beyond.

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
    beyond
        (K, 3) points on other surfaces, m. Without them rings have no opening.
    """
    beyond = np.zeros((0, 3)) if beyond is None else beyond
    for direction in directions:
        opening = _find_along(points, view_origin, direction, noise, beyond)
        if opening is not None:
            return opening
    return None


def _find_along(
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
    direction: NDArray[np.float64],
    noise: float,
    beyond: NDArray[np.float64],
) -> Opening | None:
    frame = _frame(points, view_origin, direction)
    if frame.eye[2] <= frame.local[:, 2].max():
        return None
    middle = _first_middle(frame.local)
    ring = find_ring(frame.local, middle, noise)
    for _ in range(ROUNDS):
        if ring is None:
            return None
        frame, middle = _levelled(frame, ring, points, view_origin)
        if frame.axes[2] @ direction < np.cos(MAX_TILT):
            return None
        ring = find_ring(frame.local, middle, noise)
    if ring is None:
        return None
    ring = with_ellipse(ring)
    if not ring.is_level_ellipse(noise):
        return None
    found = (_entered(frame, ring, noise, beyond, share) for share in INNER_SHARES)
    return next((opening for opening in found if opening is not None), None)


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


def _levelled(
    frame: _Frame,
    ring: Ring,
    points: NDArray[np.float64],
    view_origin: NDArray[np.float64],
) -> tuple[_Frame, NDArray[np.float64]]:
    """Return the frame with the normal of the ring's plane as z, and the middle in it."""
    slope_x, slope_y, offset = ring.plane
    normal = np.array([-slope_x, -slope_y, 1.0]) @ frame.axes
    levelled = _frame(points, view_origin, normal / np.linalg.norm(normal))
    middle = np.append(ring.middle, ring.plane[:2] @ ring.middle + offset) @ frame.axes
    return levelled, levelled.axes[:2] @ middle


def _entered(
    frame: _Frame,
    ring: Ring,
    noise: float,
    beyond: NDArray[np.float64],
    inner_share: float,
) -> Opening | None:
    """Return the opening if the rays through an inner share of the ring end below it."""
    height = float(np.median(ring.points[:, 2]))
    radius = float(np.mean(ring.semi_axes))
    eye = frame.eye
    away = float(np.linalg.norm(eye - np.append(ring.middle, height)))
    if eye[2] - height < MIN_VIEW_SINE * away:
        return None
    crossing = _crossings(frame.local, eye, height)
    scale = ring.scale(crossing)
    below = height - frame.local[:, 2]
    behind = beyond @ frame.axes.T
    passing = _crossings(behind, eye, height)
    seen = (ring.scale(passing) < inner_share) & (height - behind[:, 2] > 0.0)
    inner = scale < inner_share
    if not _fills(ring, np.vstack([crossing[inner], passing[seen]]), inner_share):
        return None
    depths = np.append(below[inner], height - behind[seen, 2])
    if np.quantile(depths, 0.9) < max(2.0 * MIN_DEPTH * radius, MIN_DEPTH_NOISE * noise):
        return None
    tolerance = 2.0 * noise
    if np.mean(depths > tolerance) < MIN_ENTERED:
        return None
    inside = (scale < 1.0) & (below > tolerance)
    c, s = np.cos(ring.angle), np.sin(ring.angle)
    return Opening(
        rim=Rim(
            centre=np.append(ring.middle, height) @ frame.axes,
            semi_axes=ring.semi_axes,
            directions=np.array([[c, s, 0.0], [-s, c, 0.0]]) @ frame.axes,
        ),
        inside=inside,
        lid=_at_height(crossing[inside], height) @ frame.axes,
        inner_share=inner_share,
        seen_through=beyond[seen],
        seen_lid=_at_height(passing[seen], height) @ frame.axes,
        through_share=_cells(ring, passing[seen], inner_share),
    )


def _at_height(flat: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    return np.column_stack([flat, np.full(len(flat), height)])


def _crossings(
    local: NDArray[np.float64], eye: NDArray[np.float64], height: float
) -> NDArray[np.float64]:
    """Return where the rays to points (N, 3) cross a height, (N, 2), m."""
    steps = (eye[2] - height) / np.maximum(eye[2] - local[:, 2], 1e-9)
    return eye[:2] + (local[:, :2] - eye[:2]) * steps[:, None]


def _fills(ring: Ring, crossing: NDArray[np.float64], inner_share: float) -> bool:
    """Return whether crossings (K, 2) fill the inner ellipse."""
    return _cells(ring, crossing, inner_share) >= MIN_CELLS


def _cells(ring: Ring, crossing: NDArray[np.float64], inner_share: float) -> float:
    """Return the share of the cells of the inner ellipse that crossings (K, 2) meet, 0-1."""
    c, s = np.cos(ring.angle), np.sin(ring.angle)
    unit = (crossing - ring.middle) @ np.array([[c, -s], [s, c]]) / (inner_share * ring.semi_axes)
    cells = np.clip(((unit + 1.0) / 2.0 * CELLS).astype(int), 0, CELLS - 1)
    middles = (np.arange(CELLS) + 0.5) / CELLS * 2.0 - 1.0
    in_ellipse = np.hypot(*np.meshgrid(middles, middles)) < 1.0
    filled = np.zeros((CELLS, CELLS), dtype=bool)
    filled[cells[:, 1], cells[:, 0]] = True
    return float(np.mean(filled[in_ellipse]))

"""Walls, backs and covers of furniture: large flat faces around what a support holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .median import median
from .parallel_planes import MAD_TO_SIGMA, FlatReadings, parallel_planes
from .support_extent import Support
from .working_image import WorkingImage

MAX_LEAN = 0.25
"""Maximum sine of the angle between a wall and the vertical."""
AZIMUTH_BINS = 72
"""Directions in which walls are looked for."""
AZIMUTH_REACH = 3
"""Directions on both sides of a wall's that belong to it."""
MAX_DIRECTIONS = 4
"""Maximum number of directions of walls."""
MIN_WALL_AREA = 0.02
"""Minimum visible area of a wall, m²."""
MIN_LENGTH = 0.2
"""Minimum horizontal length of a wall, m. A hand cannot lift a box of this length by its front."""
MIN_RISE = 0.35
"""Minimum height of a shorter wall, m."""
MAX_BEHIND = 0.03
"""Maximum distance at which a support is visible behind a wall, m."""
MAX_APART = 0.15
"""Maximum distance between a wall and the support that it bounds, m."""
MIN_COVER_AREA = 0.02
"""Minimum visible area of a cover, such as the underside of a board, m²."""
BAND = 0.008
"""Distance in front of a face within which readings belong to it, m."""
THICKNESS = 0.04
"""Distance behind a face within which readings belong to its edges, m."""
MARGIN = 0.05
"""Distance beyond the visible part of a face within which readings may belong to it, m."""
BAND_SIGMAS = 3.0
"""The same in σ of the face's own readings. The larger one holds."""
MIN_SPREAD = 1e-9
"""Minimum sum of squared distances along a wall, m². Equal readings determine no direction."""
REFITS = 3
"""Fits of a wall, each to the readings near the one before."""
QUANTILE = 0.01
"""Share of a face's readings outside the bounds of its visible part."""


class Face(NamedTuple):
    """A flat face of furniture, camera frame."""

    axes: NDArray[np.float64]
    """Its unit normal towards the camera, and two axes in it, as rows, (3, 3)."""
    offset: float
    """Offset of its plane, m."""
    spread: float
    """Scatter of its readings, divided by squared depth, 1/m."""
    low: NDArray[np.float64]
    """Lower bounds of its readings along the two axes, (2,), m."""
    high: NDArray[np.float64]
    """Upper bounds, (2,), m."""


def find_faces(readings: FlatReadings, supports: list[Support]) -> list[Face]:
    """Find the walls at the edges of the supports and the covers above them."""
    up = supports[0].plane.normal
    faces = []
    for normal in _wall_directions(readings, supports[0]):
        along = np.cross(normal, up)
        for _, points in parallel_planes(readings, normal):
            rise, length = np.ptp(points @ up), np.ptp(points @ along)
            if length < MIN_LENGTH and rise < MIN_RISE:
                continue
            face = _face(_upright(points, normal, up), points)
            if any(_bounds(face, support) for support in supports):
                faces.append(face)
    for _, points in parallel_planes(readings, -up):
        face = _face(np.vstack([-up, supports[0].axes]), points)
        if np.prod(face.high - face.low) >= MIN_COVER_AREA:
            faces.append(face)
    return faces


def remove_faces(
    above: NDArray[np.bool_], image: WorkingImage, faces: list[Face]
) -> NDArray[np.bool_]:
    """Return the candidates (H, W) without the readings on the faces."""
    k = image.intrinsics
    rays = (np.arange(k.width) - k.cx) / k.fx, (np.arange(k.height) - k.cy) / k.fy
    kept = above.copy()
    for face in faces:
        unmark_face(kept, image.depth, rays, face)
    return kept


def _wall_directions(readings: FlatReadings, support: Support) -> list[NDArray[np.float64]]:
    """Return the unit normals (3,) of upright faces, those of the largest area first."""
    counts = count_azimuths(readings, support.plane.normal, support.axes, AZIMUTH_BINS)
    found = []
    for _ in range(MAX_DIRECTIONS):
        area = np.hypot(counts[:, 0], counts[:, 1])
        smooth = area + np.roll(area, 1) + np.roll(area, -1)
        peak = int(np.argmax(smooth))
        if smooth[peak] < MIN_WALL_AREA:
            break
        near = np.arange(peak - AZIMUTH_REACH, peak + AZIMUTH_REACH + 1) % AZIMUTH_BINS
        direction = counts[near].sum(axis=0) @ support.axes
        found.append(direction / np.linalg.norm(direction))
        counts[near] = 0.0
    return found


def _upright(
    points: NDArray[np.float64], normal: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the axes (3, 3) of the upright face through points (N, 3): a line fit in plan."""
    along = np.cross(normal, up)
    s, d = points @ along, points @ normal
    slope = 0.0
    for _ in range(REFITS):
        s0, d0 = s.mean(), d.mean()
        slope = float((s - s0) @ (d - d0) / max(float((s - s0) @ (s - s0)), MIN_SPREAD))
        residual = np.abs(d - d0 - slope * (s - s0))
        near = residual <= 3 * MAD_TO_SIGMA * median(residual)
        s, d = s[near], d[near]
    turned = normal - slope * along
    turned /= np.linalg.norm(turned)
    return np.vstack([turned, up, np.cross(turned, up)])


def _face(axes: NDArray[np.float64], points: NDArray[np.float64]) -> Face:
    places = np.sort(points @ axes[1:].T, axis=0)
    last = len(places) - 1
    along = points @ axes[0]
    offset = -float(median(along))
    z = float(median(points[:, 2]))
    spread = BAND_SIGMAS * MAD_TO_SIGMA * float(median(np.abs(along + offset))) / max(z, 1e-6) ** 2
    low, high = places[round(QUANTILE * last)], places[round((1 - QUANTILE) * last)]
    return Face(axes, offset, spread, low, high)


def _bounds(face: Face, support: Support) -> bool:
    """Return whether a support ends at a face, and lies on the side that is visible."""
    corners = support.hull @ support.axes - support.plane.offset * support.plane.normal
    before = corners @ face.axes[0] + face.offset
    return bool(-MAX_BEHIND <= before.min() <= MAX_APART)


@njit(cache=True, nogil=True)
def unmark_face(above, depth, rays, face):
    """Unmark the readings (H, W) on a face."""
    rows, columns = depth.shape
    rays_u, rays_v = rays
    axes, offset, low, high = face.axes, face.offset, face.low, face.high
    spread = face.spread
    for v in range(rows):
        n = axes[0, 1] * rays_v[v] + axes[0, 2]
        a = axes[1, 1] * rays_v[v] + axes[1, 2]
        b = axes[2, 1] * rays_v[v] + axes[2, 2]
        for u in range(columns):
            z = np.float64(depth[v, u])
            before = z * (n + axes[0, 0] * rays_u[u]) + offset
            x, y = z * (a + axes[1, 0] * rays_u[u]), z * (b + axes[2, 0] * rays_u[u])
            on = (before < max(BAND, spread * z * z)) & (before > -THICKNESS)
            on &= (x > low[0] - MARGIN) & (x < high[0] + MARGIN)
            on &= (y > low[1] - MARGIN) & (y < high[1] + MARGIN)
            above[v, u] &= not on


@njit(cache=True, nogil=True)
def count_azimuths(readings, up, axes, bins):
    """Return the sums of the upright readings' normals in plan, weighted by area, (bins, 2)."""
    points, normals = readings.points, readings.normals
    sums = np.zeros((bins, 2))
    for i in range(len(points)):
        a, b, c = normals[i, 0], normals[i, 1], normals[i, 2]
        if abs(a * up[0] + b * up[1] + c * up[2]) >= MAX_LEAN:
            continue
        z = points[i, 2]
        slant = max(-(points[i, 0] * a + points[i, 1] * b + z * c) / z, 0.1)
        area = readings.pixel_area * z * z / slant
        x = axes[0, 0] * a + axes[0, 1] * b + axes[0, 2] * c
        y = axes[1, 0] * a + axes[1, 1] * b + axes[1, 2] * c
        k = int((np.arctan2(y, x) + np.pi) / (2.0 * np.pi) * bins) % bins
        sums[k, 0] += area * x
        sums[k, 1] += area * y
    return sums

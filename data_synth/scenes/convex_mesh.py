"""Convex triangle meshes of superquadrics, with a bound on their error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import RigidTransform

from eyehand.perception.superquadric import Superquadric

CHORD_TOLERANCE_M = 8e-5
"""Maximum distance of a face from the surface: a tenth of what a depth camera resolves at 0.5 m."""

_DENSE = 4097
"""Points of the fine polyline from which a quarter of a superellipse is resampled."""


def convex_mesh(
    solid: Superquadric, tolerance: float = CHORD_TOLERANCE_M
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Create the convex hull of points on a superquadric, in shape coordinates.

    Both generating superellipses are sampled with a density proportional to the square root of
    their curvature κ. A chord of length s is s²κ/8 away from its curve, so all chords have the same
    error: sharp ends get many points, flat sides few.

    Parameters
    ----------
    solid
        The superquadric; its pose is not used.
    tolerance
        Chord error of both curves together, m. Faces are diagonal to the grid and can have up to
        twice this error.

    Returns
    -------
    vertices, faces
        (V, 3) float64 in m and (T, 3) int64, counter-clockwise seen from outside.
    """
    a1, a2, a3 = solid.semi_axes
    e1, e2 = solid.exponents
    step = np.sqrt(8.0 * tolerance / 2.0)
    ring = _quarter(e2, a1, a2, a1, a2, step)
    # The profile is used at every angle of the ring: choose its spacing for the longer semi-axis.
    profile = _quarter(e1, 1.0, a3, max(a1, a2), a3, step)
    ring = np.vstack([ring[:-1], (ring * [-1, 1])[::-1][:-1]])
    ring = np.vstack([ring, -ring])
    profile = np.vstack([(profile * [1, -1])[::-1], profile[1:]])[1:-1]
    grid = np.empty((len(profile), len(ring), 3))
    grid[..., :2] = profile[:, None, :1] * ring
    grid[..., 2] = profile[:, None, 1]
    poles = np.array([[0.0, 0.0, a3], [0.0, 0.0, -a3]])
    local = replace(solid, pose=RigidTransform.identity())
    vertices = local.project_radially(np.vstack([grid.reshape(-1, 3), poles]))
    return hull_mesh(vertices)


def hull_mesh(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the convex hull of points (N, 3): vertices (V, 3) and outward faces (T, 3)."""
    hull = ConvexHull(points)
    used, compact = np.unique(hull.simplices, return_inverse=True)
    vertices = points[used]
    faces = compact.reshape(-1, 3).astype(np.int64)
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward, ::-1]
    return vertices, faces


def _quarter(
    exponent: float, width: float, height: float, span: float, rise: float, step: float
) -> NDArray[np.float64]:
    """Sample a quarter of a superellipse from (width, 0) to (0, height).

    The spacing is that of a curve with semi-axes (span, rise); `step` is √(8 × chord error).
    """
    angle = np.linspace(0.0, np.pi / 2, _DENSE)
    x, y = np.cos(angle), np.sin(angle)
    gauge = (x ** (2 / exponent) + y ** (2 / exponent)) ** (exponent / 2)
    x, y = x / gauge, y / gauge
    dx, dy = span * np.diff(x), rise * np.diff(y)
    turning = np.abs(np.gradient(np.unwrap(np.arctan2(dy, dx))))
    # √κ ds = √(dθ ds)
    density = np.concatenate([[0.0], np.cumsum(np.sqrt(turning * np.hypot(dx, dy)))])
    count = max(int(np.ceil(density[-1] / step)), 2)
    marks = np.linspace(0.0, density[-1], count + 1)
    points = np.column_stack(
        [width * np.interp(marks, density, x), height * np.interp(marks, density, y)]
    )
    points[0], points[-1] = (width, 0.0), (0.0, height)
    return points

"""A superquadric as a convex triangle mesh whose faces keep close to the surface."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import RigidTransform

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception.superquadric import Superquadric

CHORD_TOLERANCE_M = 8e-5
"""How far a face may lie inside the surface: a tenth of what a depth camera resolves at 0.5 m."""

_DENSE = 4097
"""Points on the fine polyline from which an arc is resampled."""


def convex_mesh(
    solid: Superquadric, tolerance: float = CHORD_TOLERANCE_M
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Convex hull of points on the surface, in shape coordinates.

    Both generating superellipses are sampled with a density that goes with the square root of
    their curvature, which gives every chord of a curve the same distance to it (s²κ/8), so that
    sharp ends get points and flat sides do not.

    Parameters
    ----------
    solid
        The superquadric; its pose is not used.
    tolerance
        Chord error of the two curves together, m. Faces cross the grid at an angle and can lie
        up to twice as far inside.

    Returns
    -------
    vertices, faces
        (V, 3) float64 in m and (T, 3) int64, counter-clockwise seen from outside.
    """
    a1, a2, a3 = solid.semi_axes
    e1, e2 = solid.exponents
    step = np.sqrt(8.0 * tolerance / 2.0)
    ring = _quarter(e2, a1, a2, a1, a2, step)
    # The profile runs through the scaled ring's every angle: space it for the longer half-width.
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


def hull_mesh(
    points: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Convex hull of points (N, 3): its corners (V, 3), and faces (T, 3) seen from outside."""
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
    """Points of a superellipse's quarter from (width, 0) to (0, height).

    They are spaced for a curve of half-axes (span, rise), `step` being √(8 × chord error).
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

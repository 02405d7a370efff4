"""Triangle mesh of a superquadric, and points drawn uniformly from its surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .shape import Superquadric

_DENSE = 4096
_SAMPLING_RESOLUTION = 64


def mesh(
    solid: Superquadric, resolution: int = 32
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a closed triangle mesh of the surface, in the frame of the solid.

    Parameters
    ----------
    solid
        The superquadric.
    resolution
        Points around the local z-axis, rounded down to a multiple of 4 so that boxes have vertices
        at their corners. Half as many points run from pole to pole.

    Returns
    -------
    vertices, faces
        (V, 3) float64, m, and (T, 3) int64, counter-clockwise seen from outside.

    Raises
    ------
    InputError
        If the resolution is below 8.
    """
    if resolution < 8:
        raise InputError(f"mesh resolution must be >= 8, got {resolution}")
    a1, a2, a3 = solid.semi_axes
    e1, e2 = solid.exponents
    ring = _superellipse(e2, a1, a2, resolution, closed=True)
    profile = _superellipse(e1, float(np.hypot(a1, a2)) / np.sqrt(2), a3, resolution, closed=False)
    radius, height = profile[1:-1].T
    grid = np.empty((len(radius), len(ring), 3))
    grid[..., 0] = a1 * radius[:, None] * ring[:, 0]
    grid[..., 1] = a2 * radius[:, None] * ring[:, 1]
    grid[..., 2] = a3 * height[:, None]
    poles = np.array([[0.0, 0.0, -a3], [0.0, 0.0, a3]])
    vertices = solid.to_parent(solid.apply_taper(np.vstack([grid.reshape(-1, 3), poles])))
    return vertices, _grid_faces(len(radius), len(ring))


def sample_surface(
    solid: Superquadric, count: int, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Draw points (count, 3), m, uniformly by area from the surface."""
    vertices, faces = mesh(solid, _SAMPLING_RESOLUTION)
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1)
    chosen = rng.choice(len(faces), size=count, p=area / area.sum())
    s, t = rng.random((2, count))
    fold = s + t > 1
    s, t = np.where(fold, 1 - s, s), np.where(fold, 1 - t, t)
    first, second, third = np.moveaxis(corners[chosen], 1, 0)
    flat = first + s[:, None] * (second - first) + t[:, None] * (third - first)
    return solid.project_radially(flat)


def _superellipse(
    exponent: float, width: float, height: float, count: int, *, closed: bool
) -> NDArray[np.float64]:
    """Return points of |x|^(2/ε) + |y|^(2/ε) = 1, evenly spaced on the curve scaled to its size.

    A closed curve has `count` points from angle 0. An open one runs from (0, -1) to (0, 1) over
    x >= 0, in count // 2 + 1 points.
    """
    quarter = np.linspace(0.0, np.pi / 2, _DENSE)
    x, y = np.cos(quarter), np.sin(quarter)
    scale = (x ** (2 / exponent) + y ** (2 / exponent)) ** (exponent / 2)
    x, y = x / scale, y / scale
    length = np.concatenate([[0], np.cumsum(np.hypot(width * np.diff(x), height * np.diff(y)))])
    # A square has its corner on the diagonal, so that each half is spaced evenly.
    middle = length[_DENSE // 2]
    per_quarter = max(count // 4, 2)
    first = max(round(per_quarter * middle / length[-1]), 1)
    first = min(first, per_quarter - 1)
    positions = np.concatenate(
        [
            np.linspace(0, middle, first + 1)[:-1],
            np.linspace(middle, length[-1], per_quarter - first + 1),
        ]
    )
    arc = np.column_stack([np.interp(positions, length, x), np.interp(positions, length, y)])
    arc[0], arc[-1] = (1.0, 0.0), (0.0, 1.0)
    if not closed:
        return np.vstack([(arc * [1, -1])[::-1], arc[1:]])
    half = np.vstack([arc[:-1], (arc * [-1, 1])[::-1][:-1]])
    return np.vstack([half, -half])


def _grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns), indexing="ij")
    following = (column + 1) % columns
    a, b = row * columns + column, row * columns + following
    c, d = a + columns, b + columns
    sides = np.concatenate(
        [np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    )
    around = np.arange(columns)
    after = (around + 1) % columns
    bottom, top = rows * columns, rows * columns + 1
    last = (rows - 1) * columns
    bottom_fan = np.stack([np.full(columns, bottom), after, around], -1)
    top_fan = np.stack([np.full(columns, top), last + around, last + after], -1)
    return np.concatenate([sides, bottom_fan, top_fan])

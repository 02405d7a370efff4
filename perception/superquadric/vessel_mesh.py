"""Closed triangle mesh of a vessel: outer surface, rim and cavity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from .vessel import Vessel

BISECTIONS = 24
"""Halvings of a radius: to 1e-8 of the size."""
FIRST_ROW = 1e-3
"""Height of the lowest row above the foot, as a share of the height: at the foot a round solid has
no radius."""


def vessel_mesh(
    vessel: Vessel, resolution: int = 32
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return a closed triangle mesh of a vessel or ring, in its frame.

    Parameters
    ----------
    vessel
        The vessel. A wall that is not known is drawn with `drawn_wall`.
    resolution
        Points around the axis. Half as many rows run from the foot to the rim, outside and inside.

    Returns
    -------
    vertices, faces
        (V, 3) float64, m, and (T, 3) int64, counter-clockwise seen from the air.

    Raises
    ------
    InputError
        If the resolution is below 8.
    """
    if resolution < 8:
        raise InputError(f"mesh resolution must be >= 8, got {resolution}")
    rows = resolution // 2
    up, top = vessel.opening, vessel.top_height
    foot = vessel.foot_height
    shares = 0.5 - 0.5 * np.cos(np.pi * np.linspace(FIRST_ROW**0.5, 1.0, rows))
    outside = foot + (top - foot) * shares
    floor = foot if vessel.through else min(foot + vessel.drawn_wall, 0.5 * (foot + top))
    inside = floor + (top - floor) * shares[::-1]
    axis = vessel.outer.centre - float(vessel.heights(vessel.outer.centre)) * up
    turn = np.linspace(0.0, 2.0 * np.pi, resolution, endpoint=False)
    around = np.column_stack([np.cos(turn), np.sin(turn)]) @ vessel.rim.directions
    reach = 2.0 * float(vessel.outer.semi_axes.max())
    # The edge of a superquadric is round. The wall of a vessel reaches up to the rim.
    level = np.minimum(outside, vessel.edge_height)
    grids = [
        _rings(vessel.outer.distance, axis, up, level, around, reach, outside),
        _rings(vessel.cavity_distance, axis, up, inside, around, reach, inside),
    ]
    rings = np.concatenate([grid.reshape(-1, 3) for grid in grids])
    if vessel.through:
        return rings, _faces(2 * rows, resolution, closed=True)
    ends = np.array([axis + foot * up, axis + floor * up])
    return np.concatenate([rings, ends]), _faces(2 * rows, resolution, closed=False)


def _rings(
    distance: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    axis: NDArray[np.float64],
    up: NDArray[np.float64],
    levels: NDArray[np.float64],
    around: NDArray[np.float64],
    reach: float,
    heights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return points (R, C, 3) at heights (R,) whose radii are those of the surface at the levels.

    The surface is where `distance` changes its sign on a ray from the axis along `around` (C, 3).
    """
    middles = axis + levels[:, None] * up
    low = np.zeros((len(levels), len(around)))
    high = np.full_like(low, reach)
    for _ in range(BISECTIONS):
        radius = 0.5 * (low + high)
        inside = distance(middles[:, None] + radius[..., None] * around) < 0.0
        low, high = np.where(inside, radius, low), np.where(inside, high, radius)
    return (axis + heights[:, None] * up)[:, None] + (0.5 * (low + high))[..., None] * around


def _faces(rows: int, columns: int, *, closed: bool) -> NDArray[np.int64]:
    """Return the faces of a grid of rings.

    A closed grid joins its last ring to its first one, as that of a ring. The ends of another one
    are fans to the two last vertices.
    """
    joined = rows if closed else rows - 1
    row, column = np.meshgrid(np.arange(joined), np.arange(columns), indexing="ij")
    following = (column + 1) % columns
    a, b = row * columns + column, row * columns + following
    below = (row + 1) % rows * columns
    c, d = below + column, below + following
    sides = [
        np.stack([a, b, d], -1).reshape(-1, 3),
        np.stack([a, d, c], -1).reshape(-1, 3),
    ]
    if closed:
        return np.concatenate(sides)
    around = np.arange(columns)
    after = (around + 1) % columns
    foot, floor = rows * columns, rows * columns + 1
    last = (rows - 1) * columns
    return np.concatenate(
        [
            *sides,
            np.stack([np.full(columns, foot), after, around], -1),
            np.stack([np.full(columns, floor), last + around, last + after], -1),
        ]
    )

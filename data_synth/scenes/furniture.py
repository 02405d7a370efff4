"""Furniture made of fixtures: containers, tables, shelves, and what stands in a room."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform

from .fixture import BackgroundKind, Colour, Fixture, box, hull

BOARD_M = 0.02
"""Thickness of table tops and shelf boards."""
LEG_M = 0.04
"""Width of a table's legs."""
_WALL_M = 0.05
_SIDES = ((1, 0), (0, 1), (-1, 0), (0, -1))


def container(
    size: tuple[float, float],
    height: float,
    colour: Colour,
    *,
    taper: float = 0.0,
    thickness: float = 0.004,
    lip: float = 0.0,
) -> list[Fixture]:
    """Make an open container that stands on z = 0 around the z-axis.

    Parameters
    ----------
    size
        Inner extent of the floor along x and y, m.
    height
        Height of the walls over the inner floor, m.
    colour
        Colour of all parts.
    taper
        Angle by which the walls lean outwards, rad.
    thickness
        Thickness of floor and walls, m.
    lip
        Width of a horizontal rim around the top, outwards, m; 0 for none.
    """
    floor = (*(np.array(size) / 2 + thickness), thickness)
    parts = [box("container_floor", [-floor[0], -floor[1], 0], floor, colour)]
    top = thickness + height
    opening = np.array(size) + 2 * height * np.tan(taper)
    for side in _SIDES:
        bottom_edge = _edge(size, side, thickness, thickness)
        top_edge = _edge(opening, side, thickness, top)
        parts.append(hull("container_wall", np.vstack([bottom_edge, top_edge]), colour))
        if lip > 0:
            under = _edge(opening, side, lip, top - thickness)
            over = _edge(opening, side, lip, top)
            parts.append(hull("container_wall", np.vstack([under, over]), colour))
    return parts


def table(size: tuple[float, float], drop: float, colour: Colour) -> list[Fixture]:
    """Make a table with four legs. Its top is at z = 0, and the floor lies `drop` m below."""
    x, y = np.array(size) / 2
    parts = [box("table", [-x, -y, -BOARD_M], [x, y, 0], colour)]
    for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        corner = np.array([sx * (x - LEG_M), sy * (y - LEG_M)])
        low, high = [*(corner - LEG_M / 2), -drop], [*(corner + LEG_M / 2), -BOARD_M]
        parts.append(box("table", low, high, colour))
    return parts


def pedestal(
    size: tuple[float, float], drop: float, colour: Colour, *, turned: bool
) -> list[Fixture]:
    """Make a small table on one column; `turned` makes its top a disc of diameter ``size[0]``."""
    x, y = np.array(size) / 2
    if turned:
        centre = RigidTransform.from_translation([0.0, 0.0, -BOARD_M / 2])
        top = Fixture("table", "cylinder", (x, x, BOARD_M / 2), pose=centre, colour=colour)
    else:
        top = box("table", [-x, -y, -BOARD_M], [x, y, 0], colour)
    radius = 0.15 * min(x, y) + 0.02
    middle = RigidTransform.from_translation([0.0, 0.0, -(drop + BOARD_M) / 2])
    half = (radius, radius, (drop - BOARD_M) / 2)
    return [top, Fixture("table", "cylinder", half, pose=middle, colour=colour)]


def shelf(
    size: tuple[float, float], levels: tuple[float, ...], height: float, colour: Colour
) -> list[Fixture]:
    """Make a shelf that opens towards -y, with its middle over the z-axis.

    Parameters
    ----------
    size
        Width along x and depth along y, m.
    levels
        World z of the upper face of each board, rising, m.
    height
        World z of the top of the side and back walls, m.
    colour
        Colour of boards and walls.
    """
    x, y = np.array(size) / 2
    low = levels[0] - BOARD_M
    parts = [box("board", [-x, -y, z - BOARD_M], [x, y, z], colour) for z in levels]
    parts.append(box("wall", [-x, y, low], [x, y + BOARD_M, height], colour))
    for side in (-1, 1):
        edges = sorted((side * x, side * (x + BOARD_M)))
        parts.append(box("wall", [edges[0], -y, low], [edges[1], y + BOARD_M, height], colour))
    return parts


def ground(z: float, colour: Colour, kind: BackgroundKind = "floor") -> Fixture:
    """Make a floor at world height `z`, m."""
    return Fixture(kind, "plane", pose=RigidTransform.from_translation([0, 0, z]), colour=colour)


def room_wall(distance: float, z: float, colour: Colour) -> Fixture:
    """Make a wall that faces -y at y = `distance`, m, and stands on the floor at height `z`."""
    return box("wall", [-3, distance, z], [3, distance + _WALL_M, z + 2.5], colour)


def chair(z: float, colour: Colour) -> list[Fixture]:
    """Make a chair over the z-axis that faces +y, on the floor at height `z`, m."""
    seat, back = z + 0.45, z + 0.95
    parts = [box("surroundings", [-0.22, -0.22, seat - 0.04], [0.22, 0.22, seat], colour)]
    parts.append(box("surroundings", [-0.22, -0.24, seat + 0.08], [0.22, -0.21, back], colour))
    for sx in (-1, 1):
        for sy in (-1, 1):
            foot = np.array([sx * 0.2, sy * 0.2])
            high = back if sy < 0 else seat - 0.04
            parts.append(box("surroundings", [*(foot - 0.015), z], [*(foot + 0.015), high], colour))
    return parts


def screen(width: float, colour: Colour) -> list[Fixture]:
    """Make a computer screen over the z-axis that faces -y and stands on z = 0; width in m."""
    high = 0.6 * width
    low = 0.1
    return [
        box("surroundings", [-width / 2, 0.0, low], [width / 2, 0.03, low + high], colour),
        box("surroundings", [-0.03, 0.03, 0.0], [0.03, 0.05, low + high / 2], colour),
        box("surroundings", [-0.13, -0.06, 0.0], [0.13, 0.12, 0.012], colour),
    ]


def cabinet(size: tuple[float, float, float], z: float, colour: Colour) -> list[Fixture]:
    """Make a closed cabinet over the z-axis on the floor at height `z`; extents in m."""
    x, y = size[0] / 2, size[1] / 2
    return [box("surroundings", [-x, -y, z], [x, y, z + size[2]], colour)]


def _edge(
    inner: tuple[float, float] | np.ndarray, side: tuple[int, int], width: float, z: float
) -> np.ndarray:
    """Return the corners (4, 3) of a strip of `width` along one side of a rectangle at height z."""
    half = np.asarray(inner) / 2
    out = np.array(side)
    along = np.array([-side[1], side[0]])
    corners = []
    for grow in (0.0, width):
        for sign in (-1, 1):
            # The outer edge is longer: neighbouring walls meet without a gap.
            reach = half + grow
            corners.append([*(out * reach + sign * along * reach), z])
    return np.array(corners)

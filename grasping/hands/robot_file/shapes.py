"""Triangles of a model's shapes, clipping them, and boxes around them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .read_model import Model, load_mujoco

ROUND_STEPS = 32
"""Points around a round shape. A multiple of 4 keeps its extents along its axes exact."""
CELL = 1e-3
"""Height of the slabs before they are joined to boxes, m."""
MAX_CELLS = 400
"""Maximum number of those slabs."""
MAX_BOXES = 6
"""Maximum number of boxes of one part."""
ADDED_SHARE = 0.04
"""Two boxes are joined while this adds less than this share of the whole volume."""
MIN_SIDE = 2e-4
"""Minimum side of a box, m."""


def geom_triangles(model: Model, geom: int) -> NDArray[np.float64]:
    """Return the triangles of a geom in its own frame, (T, 3, 3), m; none of planes and fields."""
    kinds = load_mujoco().mjtGeom
    kind, size = int(model.geom_type[geom]), np.array(model.geom_size[geom])
    if kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        vertices = np.array(model.mesh_vert[first : first + count], dtype=np.float64)
        first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        return vertices[model.mesh_face[first : first + count]]
    if kind == kinds.mjGEOM_BOX:
        return _BOX * size
    if kind in (kinds.mjGEOM_SPHERE, kinds.mjGEOM_ELLIPSOID):
        return _round(np.zeros(2)) * (size if kind == kinds.mjGEOM_ELLIPSOID else size[0])
    if kind == kinds.mjGEOM_CAPSULE:
        return _round(np.array([-size[1], size[1]]) / size[0]) * size[0]
    if kind == kinds.mjGEOM_CYLINDER:
        return _cylinder() * [size[0], size[0], size[1]]
    return np.zeros((0, 3, 3))


def solid_geoms(model: Model, bodies: Sequence[int]) -> list[int]:
    """Return the geoms of bodies that are fixed to each other: those that collide, else all."""
    geoms = [geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in set(bodies)]
    solid = [g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]]
    return solid or geoms


def clipped(
    triangles: NDArray[np.float64], axis: int, low: float, high: float
) -> NDArray[np.float64]:
    """Return points (N, 3) whose box is that of the part of triangles between two planes.

    They are the corners between the planes, and the points where edges cross a plane.
    """
    least, most = _spans(triangles, axis)
    return _cut(triangles[(most >= low) & (least <= high)], axis, low, high)


def _spans(
    triangles: NDArray[np.float64], axis: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least and the greatest coordinate of each triangle, (T,)."""
    # NumPy reduces short axes ten times slower than it compares columns.
    a, b, c = triangles[:, 0, axis], triangles[:, 1, axis], triangles[:, 2, axis]
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _cut(triangles: NDArray[np.float64], axis: int, low: float, high: float) -> NDArray[np.float64]:
    """Return the points of `clipped` from triangles that meet the slab."""
    corners = triangles.reshape(-1, 3)
    points = [corners[(corners[:, axis] >= low) & (corners[:, axis] <= high)]]
    start, end = triangles, np.roll(triangles, -1, axis=1)
    for plane in (low, high):
        a, b = start[:, :, axis] - plane, end[:, :, axis] - plane
        crosses = a * b < 0
        share = (a[crosses] / (a[crosses] - b[crosses]))[:, None]
        points.append(start[crosses] + share * (end[crosses] - start[crosses]))
    return np.concatenate(points)


def clipped_box(
    triangles: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the parts of triangles inside a box as triangles, (T, 3, 3)."""
    inside = triangles
    for axis in range(3):
        least, most = _spans(inside, axis)
        inside = inside[(most >= low[axis]) & (least <= high[axis])]
    for axis in range(3):
        inside = beyond_plane(inside, axis, 1.0, float(low[axis]))
        inside = beyond_plane(inside, axis, -1.0, -float(high[axis]))
    return inside


def beyond_plane(
    triangles: NDArray[np.float64], axis: int, sign: float, bound: float
) -> NDArray[np.float64]:
    """Return the parts of triangles where sign * coordinate >= bound, as triangles (T, 3, 3)."""
    if not np.isfinite(bound):
        return triangles
    height = sign * triangles[:, :, axis] - bound
    inside = height >= 0
    count = inside.sum(axis=1)
    # With one corner inside a triangle is left, with two a quadrangle. The odd corner comes first.
    one = _first(triangles, height, count == 1, inside)
    two = _first(triangles, height, count == 2, ~inside)
    parts = [triangles[count == 3]]
    if len(one[0]):
        corner, first, second = one[0][:, 0], *_crossings(*one)
        parts.append(np.stack([corner, first, second], axis=1))
    if len(two[0]):
        first, second = _crossings(*two)
        b, c = two[0][:, 1], two[0][:, 2]
        parts += [np.stack([b, c, second], axis=1), np.stack([b, second, first], axis=1)]
    return np.concatenate(parts)


def _first(
    triangles: NDArray[np.float64],
    height: NDArray[np.float64],
    chosen: NDArray[np.bool_],
    odd: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return chosen triangles and heights with the odd corner first."""
    rows = np.flatnonzero(chosen)
    order = (np.argmax(odd[rows], axis=1)[:, None] + np.arange(3)) % 3
    return triangles[rows[:, None], order], height[rows[:, None], order]


def _crossings(
    triangles: NDArray[np.float64], height: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where the edges from the first corner cross the plane, two arrays (T, 3)."""
    start = triangles[:, 0]
    found = []
    for end in (1, 2):
        share = (height[:, 0] / (height[:, 0] - height[:, end]))[:, None]
        found.append(start + share * (triangles[:, end] - start))
    return found[0], found[1]


def slab_boxes(
    clouds: Sequence[NDArray[np.float64]], low: float = -np.inf, high: float = np.inf
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Enclose triangles in few boxes stacked along z.

    Parameters
    ----------
    clouds
        Triangles (T, 3, 3) of the part, in one posture or several, m.
    low, high
        Only the part between these z is enclosed, m.

    Returns
    -------
    list of (low, high)
        Corners (3,) of at most `MAX_BOXES` boxes, from the least z, m.
    """
    triangles = np.concatenate([np.zeros((0, 3, 3)), *clouds])
    if not len(triangles):
        return []
    low = max(low, float(triangles[:, :, 2].min()))
    high = min(high, float(triangles[:, :, 2].max()))
    if high - low < MIN_SIDE:
        return []
    count = int(np.clip(np.ceil((high - low) / CELL), 1, MAX_CELLS))
    planes = np.linspace(low, high, count + 1)
    boxes = []
    starts, ends = _spans(triangles, 2)
    for bottom, top in itertools.pairwise(planes):
        points = _cut(triangles[(ends >= bottom) & (starts <= top)], 2, bottom, top)
        if len(points):
            least, most = points.min(axis=0), points.max(axis=0)
            least[2], most[2] = bottom, top
            boxes.append((least, most))
    return [_thick(*box) for box in _merged(boxes)]


def _merged(
    boxes: list[tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Join neighbouring boxes, those first that add the least volume."""
    low, high = np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes])
    whole = float(np.prod(high - low, axis=1).sum())
    while len(low) > 1:
        least, most = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
        volume = np.prod(high - low, axis=1)
        added = np.prod(most - least, axis=1) - volume[:-1] - volume[1:]
        best = int(np.argmin(added))
        if len(low) <= MAX_BOXES and added[best] > ADDED_SHARE * whole:
            break
        low[best], high[best] = least[best], most[best]
        low, high = np.delete(low, best + 1, axis=0), np.delete(high, best + 1, axis=0)
    return list(zip(low, high, strict=True))


def _thick(
    low: NDArray[np.float64], high: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Widen sides that are too short for a box."""
    lack = np.maximum(MIN_SIDE - (high - low), 0.0) / 2
    return low - lack, high + lack


def _grid(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the triangles of a grid of points (rows, columns, 3)."""
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate(
        [np.stack(three, axis=2).reshape(-1, 3, 3) for three in ((a, b, c), (a, c, d))]
    )


def _round(ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a unit sphere, its halves moved to two places along z."""
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND_STEPS + 1)
    rise = np.linspace(-np.pi / 2, np.pi / 2, ROUND_STEPS // 2 + 1)
    half = len(rise) // 2
    rise = np.concatenate([rise[: half + 1], rise[half:]])
    shift = np.repeat(ends, [half + 1, len(rise) - half - 1])
    x = np.cos(rise)[:, None] * np.cos(turn)
    y = np.cos(rise)[:, None] * np.sin(turn)
    z = np.broadcast_to((np.sin(rise) + shift)[:, None], x.shape)
    return _grid(np.stack([x, y, z], axis=2))


def _cylinder() -> NDArray[np.float64]:
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND_STEPS + 1)
    rows = [(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)]
    points = [[[r * np.cos(t), r * np.sin(t), z] for t in turn] for r, z in rows]
    return _grid(np.array(points))


def _unit_box() -> NDArray[np.float64]:
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            corners = np.zeros((4, 3))
            corners[:, axis] = side
            corners[:, (axis + 1) % 3] = [-1, 1, 1, -1]
            corners[:, (axis + 2) % 3] = [-1, -1, 1, 1]
            faces += [corners[[0, 1, 2]], corners[[0, 2, 3]]]
    return np.array(faces)


_BOX = _unit_box()

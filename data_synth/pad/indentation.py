"""How deep solids reach into a column of the foam, one by one and together: compiled."""

from __future__ import annotations

from numba import njit

from .column_entry import NO_ENTRY, column_entry
from .contact_window import AXIS_X, AXIS_Y, HIGH_U, HIGH_V, LOW_U, LOW_V, WINDOW_FIELDS

WINDOW = 16
"""Where the window begins in a packed solid."""
SOLID_FIELDS = WINDOW + WINDOW_FIELDS
"""Fields of a packed solid: kind, sizes (3), rotation row by row (9) and place (3) in the pad's
frame, and its window (see :mod:`pad_windows`)."""
NO_DEPTH = -1.0
"""Depth where a solid does not reach into the column."""

_UX, _UY = WINDOW + AXIS_X, WINDOW + AXIS_Y
_LOW_U, _HIGH_U = WINDOW + LOW_U, WINDOW + HIGH_U
_LOW_V, _HIGH_V = WINDOW + LOW_V, WINDOW + HIGH_V
_SHARING_SCALE = 1e6


@njit(cache=True, error_model="numpy")
def depth_in_column(solid, thickness, x, y):
    """How deep a solid (see :func:`solid_of`) reaches into the column at (x, y), m.

    :data:`NO_DEPTH` where the solid is not over the column and where it lies wholly behind the
    foam; below 0 over a gap.
    """
    kind, a, b, c, xx, xy, xz, yx, yy, yz, zx, zy, zz, tx, ty, tz = solid
    px, py = x - tx, y - ty
    ox = xx * px + yx * py - zx * tz
    oy = xy * px + yy * py - zy * tz
    oz = xz * px + yz * py - zz * tz
    low = column_entry(kind, a, b, c, ox, oy, oz, zx, zy, zz)
    if low == NO_ENTRY:
        return NO_DEPTH
    if low < -thickness:
        high = -column_entry(kind, a, b, c, ox, oy, oz, -zx, -zy, -zz)
        if high < -thickness:
            return NO_DEPTH
    return -low


@njit(cache=True, error_model="numpy")
def shared_column(depth, rivals, solids, thickness, x, y):
    """Give the depth of the deepest solid in a column, and this one's share of bearing it.

    Shares add up to 1, so that solids which overlap, as the links of a cable do, are borne only
    once; they go with a power of the depth, so that they change smoothly from one to the next.
    """
    deepest = depth
    total = _weight(depth)
    for i in range(len(rivals)):
        j = rivals[i]
        u = solids[j, _UX] * x + solids[j, _UY] * y
        v = solids[j, _UX] * y - solids[j, _UY] * x
        if u < solids[j, _LOW_U] or u > solids[j, _HIGH_U]:
            continue
        if v < solids[j, _LOW_V] or v > solids[j, _HIGH_V]:
            continue
        rival = depth_in_column(solid_of(solids, j), thickness, x, y)
        if rival > 0.0:
            deepest = max(deepest, rival)
            total += _weight(rival)
    return deepest, _weight(depth) / total


@njit(cache=True, error_model="numpy")
def pack_solid(kind, size, rotation, place, window, solid):
    """Write a solid's numbers into a row (SOLID_FIELDS,) float64."""
    solid[0] = kind
    solid[1:4] = size
    for i in range(3):
        for j in range(3):
            solid[4 + 3 * i + j] = rotation[i, j]
    solid[13:16] = place
    solid[WINDOW:] = window


@njit(cache=True, error_model="numpy")
def solid_of(solids, k):
    """Gather a solid in a tuple: its numbers then stay in registers."""
    return (
        int(solids[k, 0]),
        solids[k, 1],
        solids[k, 2],
        solids[k, 3],
        solids[k, 4],
        solids[k, 5],
        solids[k, 6],
        solids[k, 7],
        solids[k, 8],
        solids[k, 9],
        solids[k, 10],
        solids[k, 11],
        solids[k, 12],
        solids[k, 13],
        solids[k, 14],
        solids[k, 15],
    )


@njit(cache=True, error_model="numpy")
def _weight(depth):
    square = depth * depth * _SHARING_SCALE
    fourth = square * square
    return fourth * fourth

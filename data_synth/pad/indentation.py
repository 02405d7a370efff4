"""Indentation depth of solids in a foam column, one by one and together (compiled)."""

from __future__ import annotations

from numba import njit

from .column_entry import NO_ENTRY, column_entry
from .contact_window import AXIS_X, AXIS_Y, HIGH_U, HIGH_V, LOW_U, LOW_V, WINDOW_FIELDS

WINDOW = 16
"""Index of the window in a packed solid."""
SOLID_FIELDS = WINDOW + WINDOW_FIELDS
"""Number of fields of a packed solid: kind, sizes (3), rotation row by row (9) and position (3) in
the pad's frame, and its window (see :mod:`contact_window`)."""
NO_DEPTH = -1.0
"""Depth where a solid does not reach into the column."""

_UX, _UY = WINDOW + AXIS_X, WINDOW + AXIS_Y
_LOW_U, _HIGH_U = WINDOW + LOW_U, WINDOW + HIGH_U
_LOW_V, _HIGH_V = WINDOW + LOW_V, WINDOW + HIGH_V
_SHARING_SCALE = 1e6


@njit(cache=True, error_model="numpy")
def depth_in_column(solid, thickness, x, y):
    """Compute how deep a solid (see :func:`unpack_solid`) reaches into the column at (x, y), m.

    The depth is :data:`NO_DEPTH` if the solid is not over the column or lies wholly behind the
    foam. It is negative over a gap.
    """
    kind, a, b, c, xx, xy, xz, yx, yy, yz, zx, zy, zz, tx, ty, tz = solid
    px, py = x - tx, y - ty
    point = (
        xx * px + yx * py - zx * tz,
        xy * px + yy * py - zy * tz,
        xz * px + yz * py - zz * tz,
    )
    low = column_entry(kind, (a, b, c), point, (zx, zy, zz))
    if low == NO_ENTRY:
        return NO_DEPTH
    if low < -thickness:
        high = -column_entry(kind, (a, b, c), point, (-zx, -zy, -zz))
        if high < -thickness:
            return NO_DEPTH
    return -low


@njit(cache=True, error_model="numpy")
def shared_column(depth, rivals, solids, thickness, x, y):
    """Return the depth of the deepest solid in a column, and this solid's share of its force.

    The shares add up to 1, so solids that overlap, such as the links of a cable, are counted once.
    A share grows with a power of the depth, so it changes smoothly from one solid to the next.
    """
    max_depth = depth
    total = _weight(depth)
    for i in range(len(rivals)):
        j = rivals[i]
        u = solids[j, _UX] * x + solids[j, _UY] * y
        v = solids[j, _UX] * y - solids[j, _UY] * x
        if u < solids[j, _LOW_U] or u > solids[j, _HIGH_U]:
            continue
        if v < solids[j, _LOW_V] or v > solids[j, _HIGH_V]:
            continue
        rival = depth_in_column(unpack_solid(solids, j), thickness, x, y)
        if rival > 0.0:
            max_depth = max(max_depth, rival)
            total += _weight(rival)
    return max_depth, _weight(depth) / total


@njit(cache=True, error_model="numpy")
def pack_solid(kind, size, rotation, position, window, solid):
    """Write the numbers of a solid into a row (SOLID_FIELDS,) float64."""
    solid[0] = kind
    solid[1:4] = size
    for i in range(3):
        for j in range(3):
            solid[4 + 3 * i + j] = rotation[i, j]
    solid[13:16] = position
    solid[WINDOW:] = window


@njit(cache=True, error_model="numpy")
def unpack_solid(solids, k):
    """Return a solid as a tuple, so that its numbers stay in registers."""
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

"""Compiled bounding rectangle, in the pad's plane, of the part of a solid below the surface.

Only this rectangle, the window, is sampled. It turns with the solid. So the straight edge of a box
lies on its border, and a thin strip of contact is sampled as finely as a wide one.
"""

from __future__ import annotations

from math import cos, hypot, pi, sin, sqrt

import numpy as np
from numba import njit

from .column_entry import BOX, CAPSULE, CYLINDER, SPHERE

AXIS_X, AXIS_Y, LOW_U, HIGH_U, LOW_V, HIGH_V = 0, 1, 2, 3, 4, 5
"""Fields of a window: the unit vector of its u-axis in the pad's plane, and the bounds along u and
v, m. The v-axis is the u-axis turned by 90 degrees. The origin is that of the pad."""
WINDOW_FIELDS = 6
"""Number of fields of a window."""

_RIM_POINTS = 16
"""Corners of the polygon around a cylinder's end: the window is at most 2 % too wide."""
_BOX_CORNERS = 8
_EPSILON = 1e-9
"""Lengths, m, and components of unit vectors below this count as 0."""


@njit(cache=True)
def sunken_window(kind, size, rotation, position, half_x, half_y, window):
    """Bound the part of a solid below the pad's surface and within its borders.

    Parameters
    ----------
    kind
        Kind of geom (see :mod:`column_entry`).
    size
        Size of the geom as in MuJoCo, (3,) float64, m.
    rotation
        R_pad_solid, (3, 3) float64.
    position
        Centre of the solid in the pad's frame, (3,) float64, m.
    half_x, half_y
        Half extents of the pad, m.
    window
        Output, (WINDOW_FIELDS,) float64.

    Returns
    -------
    bool
        Whether a part of the solid lies below the pad's surface; if not, the window is not valid.
    """
    _choose_axis(kind, size, rotation, window)
    window[LOW_U], window[HIGH_U], window[LOW_V], window[HIGH_V] = 1.0, -1.0, 1.0, -1.0
    if kind == BOX:
        _box(size, rotation, position, window)
    elif kind == CYLINDER:
        _cylinder(size, rotation, position, window)
    elif kind == CAPSULE:
        _capsule(size, rotation, position, window)
    else:
        _ellipsoid(kind, size, rotation, position, window)
    if window[LOW_U] > window[HIGH_U]:
        return False
    ux, uy = abs(window[AXIS_X]), abs(window[AXIS_Y])
    along, across = half_x * ux + half_y * uy, half_x * uy + half_y * ux
    window[LOW_U], window[HIGH_U] = max(window[LOW_U], -along), min(window[HIGH_U], along)
    window[LOW_V], window[HIGH_V] = max(window[LOW_V], -across), min(window[HIGH_V], across)
    return window[LOW_U] < window[HIGH_U] and window[LOW_V] < window[HIGH_V]


@njit(cache=True)
def _choose_axis(kind, size, rotation, window):
    """Set the u-axis to the solid's longest axis, projected to the pad's plane."""
    best = 2
    if kind not in (CAPSULE, CYLINDER):
        length = -1.0
        for axis in range(3):
            weight = 1.0 if kind == BOX else size[axis]
            projected = weight * hypot(rotation[0, axis], rotation[1, axis])
            if projected > length + _EPSILON:
                best, length = axis, projected
    x, y = rotation[0, best], rotation[1, best]
    norm = hypot(x, y)
    if kind == SPHERE or norm < _EPSILON:
        window[AXIS_X], window[AXIS_Y] = 1.0, 0.0
    else:
        window[AXIS_X], window[AXIS_Y] = x / norm, y / norm


@njit(cache=True)
def _include(window, x, y):
    """Extend the window to a point of the pad's plane."""
    u = window[AXIS_X] * x + window[AXIS_Y] * y
    v = window[AXIS_X] * y - window[AXIS_Y] * x
    if window[LOW_U] > window[HIGH_U]:
        window[LOW_U], window[HIGH_U], window[LOW_V], window[HIGH_V] = u, u, v, v
        return
    window[LOW_U], window[HIGH_U] = min(window[LOW_U], u), max(window[HIGH_U], u)
    window[LOW_V], window[HIGH_V] = min(window[LOW_V], v), max(window[HIGH_V], v)


@njit(cache=True)
def _include_edge(window, x0, y0, z0, x1, y1, z1):
    """Extend the window to the part of an edge below the surface."""
    if z0 < 0.0:
        _include(window, x0, y0)
    if z1 < 0.0:
        _include(window, x1, y1)
    if (z0 < 0.0) != (z1 < 0.0):
        share = z0 / (z0 - z1)
        _include(window, x0 + share * (x1 - x0), y0 + share * (y1 - y0))


@njit(cache=True)
def _box(size, rotation, position, window):
    corners = np.empty((_BOX_CORNERS, 3))
    for corner in range(_BOX_CORNERS):
        a = size[0] if corner & 1 else -size[0]
        b = size[1] if corner & 2 else -size[1]
        c = size[2] if corner & 4 else -size[2]
        for i in range(3):
            corners[corner, i] = (
                position[i] + rotation[i, 0] * a + rotation[i, 1] * b + rotation[i, 2] * c
            )
    for corner in range(_BOX_CORNERS):
        p = corners[corner]
        for bit in (1, 2, 4):
            if not corner & bit:
                q = corners[corner | bit]
                _include_edge(window, p[0], p[1], p[2], q[0], q[1], q[2])


@njit(cache=True)
def _cylinder(size, rotation, position, window):
    radius = size[0] / cos(pi / _RIM_POINTS)
    rims = np.empty((2, _RIM_POINTS, 3))
    for k in range(_RIM_POINTS):
        a = radius * cos(2 * pi * k / _RIM_POINTS)
        b = radius * sin(2 * pi * k / _RIM_POINTS)
        for i in range(3):
            wall = position[i] + rotation[i, 0] * a + rotation[i, 1] * b
            rims[0, k, i] = wall - rotation[i, 2] * size[1]
            rims[1, k, i] = wall + rotation[i, 2] * size[1]
    for k in range(_RIM_POINTS):
        p, q = rims[0, k], rims[1, k]
        _include_edge(window, p[0], p[1], p[2], q[0], q[1], q[2])
        for end in range(2):
            p, q = rims[end, k], rims[end, (k + 1) % _RIM_POINTS]
            _include_edge(window, p[0], p[1], p[2], q[0], q[1], q[2])


@njit(cache=True)
def _capsule(size, rotation, position, window):
    """Bound a capsule by spheres on its axis: the full sphere, or its disc if z = 0 cuts it."""
    radius, half = size[0], size[1]
    slope = rotation[2, 2]
    run = window[AXIS_X] * rotation[0, 2] + window[AXIS_Y] * rotation[1, 2]
    candidates = (-half, half, 0.0, 0.0, 0.0, 0.0, 0.0)
    count = 2
    if abs(slope) > _EPSILON:
        # Nothing lies beyond these points of the axis: where it meets the surface, where its
        # spheres leave the surface, and where the inclined tube reaches farthest to either side.
        turn = radius * run / hypot(run, slope)
        candidates = (
            -half,
            half,
            -position[2] / slope,
            (radius - position[2]) / slope,
            (-radius - position[2]) / slope,
            (turn - position[2]) / slope,
            (-turn - position[2]) / slope,
        )
        count = 7
    for k in range(count):
        t = min(max(candidates[k], -half), half)
        z = position[2] + t * slope
        if z < radius:
            reach = radius if z <= 0.0 else sqrt(radius * radius - z * z)
            x, y = position[0] + t * rotation[0, 2], position[1] + t * rotation[1, 2]
            ux, uy = reach * window[AXIS_X], reach * window[AXIS_Y]
            _include(window, x - ux + uy, y - uy - ux)
            _include(window, x + ux - uy, y + uy + ux)


@njit(cache=True)
def _ellipsoid(kind, size, rotation, position, window):
    ux, uy = window[AXIS_X], window[AXIS_Y]
    uu, vv, zz, uz, vz = 0.0, 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        r = size[0] if kind == SPHERE else size[axis]
        u = r * (ux * rotation[0, axis] + uy * rotation[1, axis])
        v = r * (ux * rotation[1, axis] - uy * rotation[0, axis])
        z = r * rotation[2, axis]
        uu, vv, zz, uz, vz = uu + u * u, vv + v * v, zz + z * z, uz + u * z, vz + v * z
    if position[2] >= sqrt(zz):
        return
    u0, v0 = ux * position[0] + uy * position[1], ux * position[1] - uy * position[0]
    low_u, high_u = _clipped_extent(u0, position[2], uu, zz, uz)
    low_v, high_v = _clipped_extent(v0, position[2], vv, zz, vz)
    window[LOW_U], window[HIGH_U], window[LOW_V], window[HIGH_V] = low_u, high_u, low_v, high_v


@njit(cache=True)
def _clipped_extent(centre, height, aa, zz, az):
    """Return the bounds along a of the part of an ellipsoid with z <= 0.

    The shape matrix in a and z is [aa az; az zz].
    """
    reach = sqrt(aa)
    low, high = centre - reach, centre + reach
    # The slice at z = 0 bounds the side whose farthest point is above the surface.
    rest = (aa - az * az / zz) * (1.0 - height * height / zz)
    across = sqrt(max(rest, 0.0))
    middle = centre - az / zz * height
    if height - az / reach > 0.0:
        low = middle - across
    if height + az / reach > 0.0:
        high = middle + across
    return low, high

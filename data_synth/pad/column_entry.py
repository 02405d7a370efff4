"""Where a line along the pad's normal enters a simple solid: compiled."""

from __future__ import annotations

from math import inf, sqrt

from numba import njit

SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 2, 3, 4, 5, 6
"""MuJoCo's numbers of the kinds of geom (`mjtGeom`) that have a closed form."""
NO_ENTRY = inf
"""What a line that misses gets."""

_PARALLEL = 1e-12


@njit(cache=True, error_model="numpy")
def column_entry(kind, a, b, c, ox, oy, oz, dx, dy, dz):
    """Find where an endless line enters a solid.

    Where it leaves is minus the entry of the line turned round.

    Parameters
    ----------
    kind
        Kind of geom: SPHERE, CAPSULE, ELLIPSOID, CYLINDER or BOX.
    a, b, c
        Sizes, m, as MuJoCo has them: radius; radius and half length; semi-axes; half edges.
    ox, oy, oz
        Point of the line in the solid's frame, m.
    dx, dy, dz
        Unit direction of the line in the solid's frame.

    Returns
    -------
    float
        Distance from the point along the direction, m, of any sign; :data:`NO_ENTRY` if the line
        does not meet the solid.
    """
    if kind == BOX:
        return _box(a, b, c, ox, oy, oz, dx, dy, dz)
    if kind == CAPSULE:
        return _capsule(a, b, ox, oy, oz, dx, dy, dz)
    if kind == CYLINDER:
        return _cylinder(a, b, ox, oy, oz, dx, dy, dz)
    if kind == SPHERE:
        return _sphere(a, ox, oy, oz, dx, dy, dz)
    # An ellipsoid is a unit sphere in stretched space; the distance is scaled back.
    px, py, pz, qx, qy, qz = ox / a, oy / b, oz / c, dx / a, dy / b, dz / c
    length = sqrt(qx * qx + qy * qy + qz * qz)
    return _sphere(1.0, px, py, pz, qx / length, qy / length, qz / length) / length


@njit(cache=True, error_model="numpy")
def _sphere(radius, ox, oy, oz, dx, dy, dz):
    along = ox * dx + oy * dy + oz * dz
    # The foot of the centre on the line keeps the square root exact far away from the sphere.
    fx, fy, fz = ox - along * dx, oy - along * dy, oz - along * dz
    square = radius * radius - (fx * fx + fy * fy + fz * fz)
    if square < 0.0:
        return NO_ENTRY
    return -along - sqrt(square)


@njit(cache=True, error_model="numpy")
def _slab(half, o, d):
    if abs(d) < _PARALLEL:
        if abs(o) > half:
            return inf, -inf
        return -inf, inf
    first, second = (-half - o) / d, (half - o) / d
    return min(first, second), max(first, second)


@njit(cache=True, error_model="numpy")
def _round_wall(radius, ox, oy, dx, dy):
    """Cut with an endless cylinder about z."""
    a = dx * dx + dy * dy
    c = ox * ox + oy * oy - radius * radius
    if a < _PARALLEL:
        if c > 0.0:
            return inf, -inf
        return -inf, inf
    b = ox * dx + oy * dy
    square = b * b - a * c
    if square < 0.0:
        return inf, -inf
    root = sqrt(square)
    return (-b - root) / a, (-b + root) / a


@njit(cache=True, error_model="numpy")
def _box(a, b, c, ox, oy, oz, dx, dy, dz):
    x0, x1 = _slab(a, ox, dx)
    y0, y1 = _slab(b, oy, dy)
    z0, z1 = _slab(c, oz, dz)
    low = max(x0, y0, z0)
    return low if low <= min(x1, y1, z1) else NO_ENTRY


@njit(cache=True, error_model="numpy")
def _cylinder(radius, half, ox, oy, oz, dx, dy, dz):
    wall0, wall1 = _round_wall(radius, ox, oy, dx, dy)
    end0, end1 = _slab(half, oz, dz)
    low = max(wall0, end0)
    return low if low <= min(wall1, end1) else NO_ENTRY


@njit(cache=True, error_model="numpy")
def _capsule(radius, half, ox, oy, oz, dx, dy, dz):
    wall0, wall1 = _round_wall(radius, ox, oy, dx, dy)
    if wall0 > wall1:
        return NO_ENTRY
    # Where the line enters the tube tells which of the three parts it enters.
    height = oz + wall0 * dz if wall0 > -inf else -inf * dz
    if height > half:
        return _sphere(radius, ox, oy, oz - half, dx, dy, dz)
    if height < -half:
        return _sphere(radius, ox, oy, oz + half, dx, dy, dz)
    return wall0

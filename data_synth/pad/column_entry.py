"""Entry of a line along the pad's normal into a simple solid (compiled)."""

from __future__ import annotations

from math import inf, sqrt

from numba import njit

SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX = 2, 3, 4, 5, 6
"""MuJoCo's numbers of the kinds of geom (`mjtGeom`) that have a closed form."""
NO_ENTRY = inf
"""Result for a line that misses the solid."""

_PARALLEL = 1e-12


@njit(cache=True, error_model="numpy")
def column_entry(kind, size, point, direction):
    """Compute where an endless line enters a solid.

    The line leaves the solid at minus the entry of the reversed line.

    Parameters
    ----------
    kind
        Kind of geom: SPHERE, CAPSULE, ELLIPSOID, CYLINDER or BOX.
    size
        Three floats, m, as MuJoCo has them: radius; radius and half length; semi-axes; half edges.
    point
        Three floats, a point of the line in the solid's frame, m.
    direction
        Three floats, unit direction of the line in the solid's frame.

    Returns
    -------
    float
        Signed distance from the point along the direction, m; :data:`NO_ENTRY` if the line misses
        the solid.
    """
    if kind == BOX:
        return _box(size, point, direction)
    if kind == CAPSULE:
        return _capsule(size, point, direction)
    if kind == CYLINDER:
        return _cylinder(size, point, direction)
    ox, oy, oz = point
    dx, dy, dz = direction
    if kind == SPHERE:
        return _sphere(size[0], ox, oy, oz, dx, dy, dz)
    # An ellipsoid is a unit sphere in stretched space; the distance is scaled back.
    a, b, c = size
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
    """Cut the line with a slab; the entry lies beyond the exit if the line misses it."""
    if abs(d) < _PARALLEL:
        if abs(o) > half:
            return inf, -inf
        return -inf, inf
    first, second = (-half - o) / d, (half - o) / d
    return min(first, second), max(first, second)


@njit(cache=True, error_model="numpy")
def _round_wall(radius, ox, oy, dx, dy):
    """Cut the line with an endless cylinder about z."""
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
def _box(size, point, direction):
    x0, x1 = _slab(size[0], point[0], direction[0])
    y0, y1 = _slab(size[1], point[1], direction[1])
    z0, z1 = _slab(size[2], point[2], direction[2])
    low = max(x0, y0, z0)
    return low if low <= min(x1, y1, z1) else NO_ENTRY


@njit(cache=True, error_model="numpy")
def _cylinder(size, point, direction):
    wall0, wall1 = _round_wall(size[0], point[0], point[1], direction[0], direction[1])
    end0, end1 = _slab(size[1], point[2], direction[2])
    low = max(wall0, end0)
    return low if low <= min(wall1, end1) else NO_ENTRY


@njit(cache=True, error_model="numpy")
def _capsule(size, point, direction):
    radius, half = size[0], size[1]
    ox, oy, oz = point
    dx, dy, dz = direction
    wall0, wall1 = _round_wall(radius, ox, oy, dx, dy)
    if wall0 > wall1:
        return NO_ENTRY
    # The height at which the line enters the tube decides which of the three parts it enters.
    height = oz + wall0 * dz if wall0 > -inf else -inf * dz
    if height > half:
        return _sphere(radius, ox, oy, oz - half, dx, dy, dz)
    if height < -half:
        return _sphere(radius, ox, oy, oz + half, dx, dy, dz)
    return wall0

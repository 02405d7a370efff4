"""Compiled signed distance, normal and closest points of two geoms, and a lower bound."""

from __future__ import annotations

import numpy as np
from numba import njit

from .capsule_in_box import axis_in_box
from .mujoco_binding import mj_geom_distance, mujoco
from .proximity_tables import BOUND, HALF, KIND, MIDDLE, SIZE

TOUCHING_M = 1e-6
"""Minimum distance at which the closest points define a normal. At a smaller one, the normal is
computed after one geom is shifted by SHIFT_M."""
SHIFT_M = 1e-5
"""Shift of a touching geom: ten times TOUCHING_M, and small compared with the radius of any
part."""

PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
BOX = int(mujoco.mjtGeom.mjGEOM_BOX)


@njit(cache=True)
def measure(world, a, b, cut_off, contact):
    """Return the signed distance of geoms a and b, m; the cut-off if they are farther apart.

    ``contact`` (9,) is filled with the normal from b to a and the closest points on a and on b.
    """
    positions, matrices, shapes = world.positions, world.matrices, world.shapes
    if shapes[a, KIND] == CAPSULE and shapes[b, KIND] == BOX:
        distance = _capsule_in_box(a, b, 1.0, positions, matrices, shapes, contact)
        if distance < np.inf:
            return distance
    elif shapes[a, KIND] == BOX and shapes[b, KIND] == CAPSULE:
        distance = _capsule_in_box(b, a, -1.0, positions, matrices, shapes, contact)
        if distance < np.inf:
            return distance
    distance = measure_apart(world.model, world.data, a, b, cut_off, contact)
    if abs(distance) < TOUCHING_M:
        _separate(world, a, b, contact)
    return distance


@njit(cache=True)
def measure_apart(model, data, a, b, cut_off, contact):
    """Do the same as `measure`, a third faster, for geoms whose `gap` is above TOUCHING_M."""
    distance = mj_geom_distance(model, data, np.int32(a), np.int32(b), cut_off, contact[3:9].ctypes)
    for axis in range(3):
        contact[axis] = contact[3 + axis] - contact[6 + axis]
    length = np.sqrt(contact[0] ** 2 + contact[1] ** 2 + contact[2] ** 2)
    # If the geoms overlap, the vector between the deepest points is opposite to the normal.
    scale = 0.0 if length == 0.0 else (1.0 if distance > 0.0 else -1.0) / length
    for axis in range(3):
        contact[axis] *= scale
    return distance


@njit(cache=True)
def _separate(world, a, b, contact):
    """Fill normal and points of touching geoms: geom a is shifted until they separate.

    If no shift separates them, the normal is the first direction with a length, usually the line
    between the centres.
    """
    positions = world.positions
    directions = np.zeros((8, 3))
    directions[0] = contact[:3]
    for axis in range(3):
        directions[1, axis] = positions[a, axis] - positions[b, axis]
        directions[2 + 2 * axis, axis] = 1.0
        directions[3 + 2 * axis, axis] = -1.0
    fallback = -1
    for k in range(8):
        length = np.sqrt(directions[k, 0] ** 2 + directions[k, 1] ** 2 + directions[k, 2] ** 2)
        if length == 0.0:
            continue
        fallback = k if fallback < 0 else fallback
        directions[k] *= SHIFT_M / length
        for axis in range(3):
            positions[a, axis] += directions[k, axis]
        distance = measure_apart(world.model, world.data, a, b, 1.0, contact)
        for axis in range(3):
            positions[a, axis] -= directions[k, axis]
            contact[3 + axis] -= directions[k, axis]
        if distance > TOUCHING_M:
            return
    for axis in range(3):
        contact[axis] = directions[fallback, axis] / SHIFT_M


@njit(cache=True)
def _capsule_in_box(capsule, box, side, positions, matrices, shapes, contact):
    """Return the distance of a capsule whose axis crosses a box, and fill ``contact``; else inf."""
    x = positions[capsule, 0] - positions[box, 0]
    y = positions[capsule, 1] - positions[box, 1]
    z = positions[capsule, 2] - positions[box, 2]
    centre = _rotate_to_frame(matrices[box], x, y, z)
    length = shapes[capsule, SIZE + 1]
    x, y, z = matrices[capsule, 2], matrices[capsule, 5], matrices[capsule, 8]
    half_axis = _rotate_to_frame(matrices[box], length * x, length * y, length * z)
    half_extents = (shapes[box, SIZE], shapes[box, SIZE + 1], shapes[box, SIZE + 2])
    separation, position, normal = axis_in_box(centre, half_axis, half_extents)
    if separation > 0.0:
        return np.inf
    radius = shapes[capsule, SIZE]
    on_capsule, on_box = (3, 6) if side > 0.0 else (6, 3)
    for row in range(3):
        out, point = 0.0, positions[box, row]
        for axis in range(3):
            onto = matrices[box, 3 * row + axis]
            out += onto * normal[axis]
            point += onto * (centre[axis] + position * half_axis[axis])
        contact[row] = side * out
        contact[on_capsule + row] = point - radius * out
        contact[on_box + row] = point - separation * out
    return separation - radius


@njit(cache=True)
def _rotate_to_frame(axes, x, y, z):
    """Return the coordinates of a world vector in a frame with axes (9,)."""
    return (
        axes[0] * x + axes[3] * y + axes[6] * z,
        axes[1] * x + axes[4] * y + axes[7] * z,
        axes[2] * x + axes[5] * y + axes[8] * z,
    )


@njit(cache=True)
def gap(a, b, positions, matrices, shapes):
    """Return a lower bound of the distance from bounding spheres and boxes; valid if above zero."""
    if shapes[b, KIND] == PLANE:
        height = 0.0
        for axis in range(3):
            up = matrices[b, 3 * axis + 2]
            height += up * (positions[a, axis] - positions[b, axis])
        return height - shapes[a, BOUND]
    return max(
        _outside(a, b, positions, matrices, shapes), _outside(b, a, positions, matrices, shapes)
    )


@njit(cache=True)
def _outside(sphere, box, positions, matrices, shapes):
    """Return the distance of a geom's bounding sphere from the bounding box of another."""
    total = 0.0
    for axis in range(3):
        along = -shapes[box, MIDDLE + axis]
        for row in range(3):
            along += matrices[box, 3 * row + axis] * (positions[sphere, row] - positions[box, row])
        beyond = abs(along) - shapes[box, HALF + axis]
        if beyond > 0.0:
            total += beyond * beyond
    return np.sqrt(total) - shapes[sphere, BOUND]

"""Meshes on the foam bed: their lower surface drawn on a grid of columns, compiled."""

from __future__ import annotations

from math import ceil, floor

import numpy as np
from numba import njit

from .contact_motion import calm_limits, into_pad, remember, twist_since
from .foam_column import HALF_X, HALF_Y, THICKNESS, add_force, column_force, deposit

_BARELY = 1e-15


@njit(cache=True, error_model="numpy")
def press_mesh(
    pad_place,
    pad_rotation,
    place,
    rotation,
    radius,
    vertices,
    faces,
    mass,
    table,
    step,
    bed,
    dt,
    before,
    wrench,
    stiffness,
    placed,
    depths,
    fine,
):
    """Press a mesh into the bed, on top of what :func:`pad_kernels.press_bed` has pressed.

    Where a mesh and another solid lie over the same column, both are borne in full.

    Parameters
    ----------
    pad_place, pad_rotation
        (3,) float64, m, and (9,) float64 row by row: the pad's frame in the world's.
    place, rotation
        The same of the mesh.
    radius
        Bounding radius about its place, m.
    vertices, faces
        (V, 3) float64 in the mesh's frame, m, and (T, 3) int32.
    mass
        Of the body it belongs to, kg; inf if it cannot be moved.
    table, step
        The law (see :func:`foam_column.table_pressure`).
    bed
        (BED_FIELDS,) float64.
    dt
        Time since the last call, s; 0 if there was none.
    before
        (POSE_FIELDS,) float64, the pose of the last call in the pad's frame; overwritten.
    wrench, stiffness
        (6,) and (1,) float64: of the last call, overwritten by force (N) and torque (N m) about
        the pad's origin on the mesh, and by the bed's normal stiffness under it, N/m.
    placed, depths
        (V, 3) and (n, n) float64, room to work in; n samples a row.
    fine
        (3, FINE * rows, FINE * columns) float64, the forces on the pad are added to it.

    Returns
    -------
    bool
        Whether it touches.
    """
    turned, moved = np.empty((3, 3)), np.empty(3)
    into_pad(pad_place, pad_rotation, place, rotation, turned, moved)
    x, y, z = moved
    beside = abs(x) > bed[HALF_X] + radius or abs(y) > bed[HALF_Y] + radius
    frame = np.empty(4)
    if (
        beside
        or z > radius
        or z < -radius - bed[THICKNESS]
        or not draw_depths(vertices, faces, turned, moved, bed, placed, depths, frame)
    ):
        before[12] = 0.0
        wrench[:] = 0.0
        stiffness[0] = 0.0
        return False
    twist = np.empty(6)
    twist_since(turned, moved, before, dt, twist)
    loss_time, slip = calm_limits(bed, dt, wrench, stiffness[0], mass)
    stiffness[0] = press_depths(
        depths, frame, table, step, bed, loss_time, slip, twist, wrench, fine
    )
    remember(turned, moved, before)
    return wrench[2] > 0.0


@njit(cache=True, error_model="numpy")
def draw_depths(vertices, faces, turned, moved, bed, placed, depths, frame):
    """Draw how deep a mesh reaches into each column of a grid over its sunken part.

    Parameters
    ----------
    vertices, faces
        (V, 3) float64 in the mesh's frame, m, and (T, 3) int32.
    turned, moved
        (3, 3) and (3,) float64: the mesh's frame in the pad's.
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    placed
        (V, 3) float64, overwritten by the vertices in the pad's frame.
    depths
        (n, n) float64, overwritten, m, rows along y; 0 where nothing is sunken.
    frame
        (4,) float64, overwritten by the grid's low x and y and its cells' extents, m.

    Returns
    -------
    bool
        Whether anything is sunken; if not, `depths` and `frame` mean nothing.
    """
    top = -np.inf
    for k in range(len(vertices)):
        for i in range(3):
            placed[k, i] = (
                moved[i]
                + turned[i, 0] * vertices[k, 0]
                + turned[i, 1] * vertices[k, 1]
                + turned[i, 2] * vertices[k, 2]
            )
        top = max(top, placed[k, 2])
    if top < -bed[THICKNESS]:
        return False
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for face in faces:
        for corner in range(3):
            p, q = face[corner], face[(corner + 1) % 3]
            z0, z1 = placed[p, 2], placed[q, 2]
            if z0 >= 0.0 and z1 >= 0.0:
                continue
            # The part of the edge below the surface, from share a to share b.
            a = 0.0 if z0 < 0.0 else z0 / (z0 - z1)
            b = 1.0 if z1 < 0.0 else z0 / (z0 - z1)
            for share in (a, b):
                x = placed[p, 0] + share * (placed[q, 0] - placed[p, 0])
                y = placed[p, 1] + share * (placed[q, 1] - placed[p, 1])
                low_x, high_x = min(low_x, x), max(high_x, x)
                low_y, high_y = min(low_y, y), max(high_y, y)
    low_x, high_x = max(low_x, -bed[HALF_X]), min(high_x, bed[HALF_X])
    low_y, high_y = max(low_y, -bed[HALF_Y]), min(high_y, bed[HALF_Y])
    if low_x >= high_x or low_y >= high_y:
        return False
    count = len(depths)
    frame[0], frame[1] = low_x, low_y
    frame[2], frame[3] = (high_x - low_x) / count, (high_y - low_y) / count
    depths[:] = 0.0
    for face in faces:
        _draw(placed, face[0], face[1], face[2], frame, depths)
    return True


@njit(cache=True, error_model="numpy")
def press_depths(depths, frame, table, step, bed, loss_time, slip, twist, wrench, fine):
    """Press a drawn mesh into the bed.

    Parameters
    ----------
    depths, frame
        As :func:`draw_depths` gives them.
    table, step
        The law (see :func:`foam_column.table_pressure`).
    bed
        (BED_FIELDS,) float64.
    loss_time, slip
        Damping over stiffness, s, and the speed at which friction is full, m/s.
    twist
        (6,) float64, the mesh's velocity at the pad's origin, m/s, and angular velocity, rad/s, in
        the pad's frame.
    wrench
        (6,) float64, overwritten by force and torque about the pad's origin on the mesh.
    fine
        (3, rows, columns) float64, forces on the pad are added to it.

    Returns
    -------
    float
        Normal stiffness, N/m.
    """
    wrench[:] = 0.0
    stiffness = 0.0
    area = frame[2] * frame[3]
    for row in range(len(depths)):
        y = frame[1] + (row + 0.5) * frame[3]
        for column in range(len(depths)):
            depth = depths[row, column]
            if depth <= 0.0:
                continue
            x = frame[0] + (column + 0.5) * frame[2]
            sinking = -(twist[2] + twist[3] * y - twist[4] * x)
            slide_x = twist[0] - twist[4] * depth - twist[5] * y
            slide_y = twist[1] + twist[3] * depth + twist[5] * x
            fz, fx, fy, slope = column_force(
                depth, sinking, slide_x, slide_y, area, table, step, bed, loss_time, slip
            )
            add_force(wrench, x, y, depth, fx, fy, fz)
            stiffness += slope
            deposit(fine, bed, x, y, fz, -fx, -fy)
    return stiffness


@njit(cache=True, error_model="numpy")
def _draw(placed, a, b, c, frame, depths):
    """Draw one triangle: the deepest one over a column counts."""
    if placed[a, 2] >= 0.0 and placed[b, 2] >= 0.0 and placed[c, 2] >= 0.0:
        return
    # In cells, with the middle of the first at 0.
    xa, ya = _cell(placed, a, frame)
    xb, yb = _cell(placed, b, frame)
    xc, yc = _cell(placed, c, frame)
    twice = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
    if abs(twice) < _BARELY:
        return
    last = len(depths) - 1
    for row in range(max(ceil(min(ya, yb, yc)), 0), min(floor(max(ya, yb, yc)), last) + 1):
        for column in range(max(ceil(min(xa, xb, xc)), 0), min(floor(max(xa, xb, xc)), last) + 1):
            wb = ((column - xa) * (yc - ya) - (xc - xa) * (row - ya)) / twice
            wc = ((xb - xa) * (row - ya) - (column - xa) * (yb - ya)) / twice
            if wb < 0.0 or wc < 0.0 or wb + wc > 1.0:
                continue
            za, zb, zc = placed[a, 2], placed[b, 2], placed[c, 2]
            z = za + wb * (zb - za) + wc * (zc - za)
            depths[row, column] = max(depths[row, column], -z)


@njit(cache=True, error_model="numpy")
def _cell(placed, k, frame):
    return (
        (placed[k, 0] - frame[0]) / frame[2] - 0.5,
        (placed[k, 1] - frame[1]) / frame[3] - 0.5,
    )

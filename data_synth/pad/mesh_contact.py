"""Contact of meshes with the foam bed: their lower surface drawn on a depth grid (compiled)."""

from __future__ import annotations

from math import ceil, floor

import numpy as np
from numba import njit

from .bristles import bristle_force
from .contact_data import ColumnLaw
from .contact_motion import stable_limits, store_pose, to_pad_frame, twist_since
from .foam_column import (
    HALF_X,
    HALF_Y,
    SHEAR_STIFFNESS,
    THICKNESS,
    add_force,
    column_force,
    deposit,
    slide_at,
)

_MIN_DOUBLE_AREA = 1e-15
"""Triangles with less than half this area, in cells, are not drawn."""


@njit(cache=True, error_model="numpy")
def press_mesh(pad, mesh, table, step, bed, dt, state, work):
    """Press a mesh into the bed, in addition to what :func:`solid_contact.press_solids` pressed.

    Where a mesh and another solid lie over the same column, the column bears both in full.

    Parameters
    ----------
    pad, mesh
        :class:`PadPose` and :class:`MeshSolid`.
    table, step
        Pressure over depth, and the depth between two entries (see :class:`ColumnLaw`).
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    dt
        Time since the last call, s; 0 if there was none.
    state
        :class:`ContactState` of this mesh alone (K = 1), overwritten.
    work
        Depth buffer (n, n) float64, n samples in a row, overwritten; the force grid (3, rows,
        columns) float64, to which the forces on the pad are added; and the bristles.

    Returns
    -------
    bool
        Whether the mesh touches.
    """
    depths, grid, bristles = work
    last_pose, wrench = state.poses[0], state.wrenches[0]
    rotation, position = np.empty((3, 3)), np.empty(3)
    to_pad_frame(pad, mesh.position, mesh.rotation, rotation, position)
    x, y, z = position
    radius = mesh.radius
    beside = abs(x) > bed[HALF_X] + radius or abs(y) > bed[HALF_Y] + radius
    frame = np.empty(4)
    if (
        beside
        or z > radius
        or z < -radius - bed[THICKNESS]
        or not _draw_depths(mesh, rotation, position, bed, depths, frame)
    ):
        last_pose[12] = 0.0
        wrench[:] = 0.0
        state.stiffness[0] = 0.0
        return False
    twist = np.empty(6)
    twist_since(rotation, position, last_pose, dt, twist)
    loss_time, slip = stable_limits(bed, dt, wrench, state.stiffness[0], mesh.mass)
    law = ColumnLaw(table, step, loss_time, slip, dt + loss_time, twist)
    state.stiffness[0] = _press_depths(depths, frame, law, bed, wrench, (grid, bristles))
    store_pose(rotation, position, last_pose)
    return wrench[2] > 0.0


@njit(cache=True, error_model="numpy")
def _draw_depths(mesh, rotation, position, bed, depths, frame):
    """Compute how deep a mesh reaches into each column of a grid over its sunken part.

    Parameters
    ----------
    mesh
        :class:`MeshSolid`.
    rotation, position
        (3, 3) and (3,) float64: the mesh's frame in the pad's.
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    depths
        (n, n) float64, overwritten, m, rows along y; 0 where nothing is sunken.
    frame
        (4,) float64, overwritten by the grid's low x and y and the extents of its cells, m.

    Returns
    -------
    bool
        Whether anything is sunken; if not, `depths` and `frame` are not valid.
    """
    vertices, placed = mesh.vertices, mesh.buffer
    top = -np.inf
    for k in range(len(vertices)):
        for i in range(3):
            placed[k, i] = (
                position[i]
                + rotation[i, 0] * vertices[k, 0]
                + rotation[i, 1] * vertices[k, 1]
                + rotation[i, 2] * vertices[k, 2]
            )
        top = max(top, placed[k, 2])
    if top < -bed[THICKNESS]:
        return False
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for face in mesh.faces:
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
    for face in mesh.faces:
        _draw_triangle(placed, face[0], face[1], face[2], frame, depths)
    return True


@njit(cache=True, error_model="numpy")
def _press_depths(depths, frame, law, bed, wrench, work):
    """Press a drawn mesh into the bed.

    Parameters
    ----------
    depths, frame
        As :func:`_draw_depths` fills them.
    law
        :class:`ColumnLaw`.
    bed
        (BED_FIELDS,) float64.
    wrench
        (6,) float64, overwritten by force and torque about the pad's origin on the mesh.
    work
        Force grid (3, rows, columns) float64, to which forces on the pad are added; and bristles.

    Returns
    -------
    float
        Normal stiffness, N/m.
    """
    grid, bristles = work
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
            fz, fx, fy, slope = column_force(depth, x, y, area, law, bed)
            if bed[SHEAR_STIFFNESS] > 0.0:
                vx, vy = slide_at(law.twist, x, y, depth)
                fx, fy = bristle_force(bristles, bed, law.lead, x, y, fz, area, vx, vy)
            add_force(wrench, x, y, depth, fx, fy, fz)
            stiffness += slope
            deposit(grid, bed, x, y, fz, -fx, -fy)
    return stiffness


@njit(cache=True, error_model="numpy")
def _draw_triangle(placed, a, b, c, frame, depths):
    """Draw one triangle; the largest depth over a column counts."""
    if placed[a, 2] >= 0.0 and placed[b, 2] >= 0.0 and placed[c, 2] >= 0.0:
        return
    # In cells, with the middle of the first at 0.
    xa, ya = _to_cells(placed, a, frame)
    xb, yb = _to_cells(placed, b, frame)
    xc, yc = _to_cells(placed, c, frame)
    twice = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
    if abs(twice) < _MIN_DOUBLE_AREA:
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
def _to_cells(placed, k, frame):
    return (
        (placed[k, 0] - frame[0]) / frame[2] - 0.5,
        (placed[k, 1] - frame[1]) / frame[3] - 0.5,
    )

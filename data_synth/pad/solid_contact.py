"""Contact of simple solids with the foam bed (compiled).

The bed is a field of independent columns along the pad's normal (Winkler foundation). The deepest
solid over a column squeezes it, and the column pushes back. Samples are laid over the window of
each solid (see :mod:`contact_window`) in rows. For a solid with edges, the two ends of the contact
are found in each row by bisection, and the samples are spread evenly between them. So the area is
exact for straight borders, and it changes smoothly as the solid moves. Rows end at the border of
the pad.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .bristles import bristle_force
from .column_entry import BOX, CYLINDER
from .contact_data import ColumnLaw
from .contact_motion import stable_limits, store_pose, to_pad_frame, twist_since
from .contact_window import (
    AXIS_X,
    AXIS_Y,
    HIGH_U,
    HIGH_V,
    LOW_U,
    LOW_V,
    WINDOW_FIELDS,
    sunken_window,
)
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
from .indentation import (
    SOLID_FIELDS,
    WINDOW,
    depth_in_column,
    pack_solid,
    shared_column,
    unpack_solid,
)

_BISECTIONS = 9
_INSET = 1e-7
_PARALLEL = 1e-12


@njit(cache=True, error_model="numpy")
def press_solids(pad, solids, tables, bed, dt, state, grid, bristles):
    """Press K simple solids into the bed.

    Parameters
    ----------
    pad, solids, tables
        :class:`PadPose`, :class:`SimpleSolids` and :class:`PressureTables`.
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    dt
        Time since the last call, s; 0 if there was none.
    state
        :class:`ContactState`, overwritten.
    grid
        (3, CELLS_PER_TACTEL * rows, CELLS_PER_TACTEL * columns) float64, overwritten by the force
        on each cell of the pad: normal, along x, along y, N.
    bristles
        (BRISTLE_FIELDS, rows, columns) float64 (see :mod:`bristles`); unused with viscous friction.

    Returns
    -------
    int
        Number of solids that touch.
    """
    count = len(solids.kinds)
    grid[:] = 0.0
    near = np.empty(count, np.int64)
    found = 0
    R_pad_solid = np.empty((count, 3, 3))
    p_pad_solid = np.empty((count, 3))
    windows = np.empty((count, WINDOW_FIELDS))
    packed = np.empty((count, SOLID_FIELDS))
    for k in range(count):
        rotation, position = R_pad_solid[k], p_pad_solid[k]
        to_pad_frame(pad, solids.positions[k], solids.rotations[k], rotation, position)
        x, y, z, reach = position[0], position[1], position[2], solids.radii[k]
        beside = abs(x) > bed[HALF_X] + reach or abs(y) > bed[HALF_Y] + reach
        if beside or z > reach or z < -reach - bed[THICKNESS]:
            continue
        kind, size = solids.kinds[k], solids.sizes[k]
        if sunken_window(kind, size, rotation, position, bed[HALF_X], bed[HALF_Y], windows[k]):
            pack_solid(kind, size, rotation, position, windows[k], packed[k])
            near[found] = k
            found += 1
    touching = 0
    others = np.empty(found, np.int64)
    for i in range(found):
        k = near[i]
        rivals = 0
        for j in range(found):
            if j != i and _overlap(windows[k], windows[near[j]]):
                others[rivals] = near[j]
                rivals += 1
        twist = np.empty(6)
        twist_since(R_pad_solid[k], p_pad_solid[k], state.poses[k], dt, twist)
        wrench = state.wrenches[k]
        loss_time, slip = stable_limits(bed, dt, wrench, state.stiffness[k], solids.masses[k])
        row = solids.laws[k]
        law = ColumnLaw(
            tables.pressures[row], tables.steps[row], loss_time, slip, dt + loss_time, twist
        )
        state.stiffness[k] = _press_solid(
            k, others[:rivals], packed, solids.samples[k], law, bed, wrench, (grid, bristles)
        )
        touching += 1 if wrench[2] > 0.0 else 0
    _update_state(near[:found], R_pad_solid, p_pad_solid, state)
    return touching


@njit(cache=True, error_model="numpy")
def _update_state(near, R_pad_solid, p_pad_solid, state):
    """Store the poses of the solids near the pad, and clear the state of all others."""
    poses = state.poses
    for k in range(len(poses)):
        poses[k, 12] = 0.0
    for k in near:
        store_pose(R_pad_solid[k], p_pad_solid[k], poses[k])
    for k in range(len(poses)):
        if poses[k, 12] == 0.0:
            state.wrenches[k] = 0.0
            state.stiffness[k] = 0.0


@njit(cache=True, error_model="numpy")
def _overlap(a, b):
    """Return whether the axis-parallel rectangles around two windows overlap."""
    ax, ay, aw, ah = _bounding_rectangle(a)
    bx, by, bw, bh = _bounding_rectangle(b)
    return abs(ax - bx) < aw + bw and abs(ay - by) < ah + bh


@njit(cache=True, error_model="numpy")
def _bounding_rectangle(window):
    """Return centre and half extents of the axis-parallel rectangle around a window."""
    ux, uy = window[AXIS_X], window[AXIS_Y]
    u, v = 0.5 * (window[LOW_U] + window[HIGH_U]), 0.5 * (window[LOW_V] + window[HIGH_V])
    a, b = 0.5 * (window[HIGH_U] - window[LOW_U]), 0.5 * (window[HIGH_V] - window[LOW_V])
    wide, high = a * abs(ux) + b * abs(uy), a * abs(uy) + b * abs(ux)
    return ux * u - uy * v, uy * u + ux * v, wide, high


@njit(cache=True, error_model="numpy")
def _row_on_pad(window, v, half_x, half_y):
    """Return the ends of the part of a window's row that lies on the pad.

    The first end is beyond the second if no part does.
    """
    ux, uy = window[AXIS_X], window[AXIS_Y]
    first, last = window[LOW_U], window[HIGH_U]
    for slope, start, half in ((ux, -uy * v, half_x), (uy, ux * v, half_y)):
        if abs(slope) > _PARALLEL:
            one, other = (-half - start) / slope, (half - start) / slope
            first, last = max(first, min(one, other)), min(last, max(one, other))
        elif abs(start) > half:
            return 1.0, -1.0
    return first, last


@njit(cache=True, error_model="numpy")
def _row_end(solid, thickness, ux, uy, v, start, step, count):
    """Step along a row to the first sample in contact, and bisect back to where contact begins.

    Returns the place, and whether there is any contact.
    """
    x0, y0 = -uy * v, ux * v
    inset = start + _INSET * step
    if depth_in_column(solid, thickness, x0 + ux * inset, y0 + uy * inset) > 0.0:
        return start, True
    outside = start
    for k in range(count):
        inside = start + (k + 0.5) * step
        if depth_in_column(solid, thickness, x0 + ux * inside, y0 + uy * inside) > 0.0:
            for _ in range(_BISECTIONS):
                middle = 0.5 * (outside + inside)
                x, y = x0 + ux * middle, y0 + uy * middle
                if depth_in_column(solid, thickness, x, y) > 0.0:
                    inside = middle
                else:
                    outside = middle
            return 0.5 * (outside + inside), True
        outside = inside
    return start, False


@njit(cache=True, error_model="numpy")
def _press_solid(k, rivals, packed, count, law, bed, wrench, work):
    """Press solid k into the bed, add its forces to the grid, and return the stiffness under it.

    `rivals` are the solids that may lie over the same columns, `count` the samples in a row, `work`
    the force grid and the bristles.
    """
    grid, bristles = work
    solid = unpack_solid(packed, k)
    half_x, half_y, thickness = bed[HALF_X], bed[HALF_Y], bed[THICKNESS]
    wrench[:] = 0.0
    stiffness = 0.0
    window = packed[k, WINDOW:]
    ux, uy = window[AXIS_X], window[AXIS_Y]
    height = (window[HIGH_V] - window[LOW_V]) / count
    # Round solids leave the foam gradually: the border of their contact needs no search.
    edged = solid[0] == BOX or solid[0] == CYLINDER
    for row in range(count):
        v = window[LOW_V] + (row + 0.5) * height
        first, last = _row_on_pad(window, v, half_x, half_y)
        if first >= last:
            continue
        if edged:
            step = (last - first) / count
            first, found = _row_end(solid, thickness, ux, uy, v, first, step, count)
            if not found:
                continue
            last, found = _row_end(solid, thickness, ux, uy, v, last, -step, count)
        cell = (last - first) / count
        area = cell * height
        for column in range(count):
            u = first + (column + 0.5) * cell
            x, y = ux * u - uy * v, uy * u + ux * v
            depth = depth_in_column(solid, thickness, x, y)
            if depth <= 0.0:
                continue
            share = 1.0
            if len(rivals):
                depth, share = shared_column(depth, rivals, packed, thickness, x, y)
            fz, fx, fy, slope = column_force(depth, x, y, share * area, law, bed)
            if bed[SHEAR_STIFFNESS] > 0.0:
                vx, vy = slide_at(law.twist, x, y, depth)
                fx, fy = bristle_force(bristles, bed, law.lead, x, y, fz, share * area, vx, vy)
            add_force(wrench, x, y, depth, fx, fy, fz)
            stiffness += slope
            deposit(grid, bed, x, y, fz, -fx, -fy)
    return stiffness

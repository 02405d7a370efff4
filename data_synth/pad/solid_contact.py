"""The foam bed as a contact: how deep solids sink into it, and what it does to them, compiled.

The bed is a field of columns along the pad's normal (Winkler): each is squeezed by the deepest
solid over it and pushes back for itself. Samples are laid over each solid's window (see
:mod:`pad_windows`) in rows. Under a solid with edges the two ends of the contact are found in each
row by bisection and the samples spread evenly between them, so that areas are exact for straight
borders and change smoothly as it moves. Rows end at the pad's border.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .column_entry import BOX, CYLINDER
from .contact_motion import calm_limits, into_pad, remember, twist_since
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
from .foam_column import HALF_X, HALF_Y, THICKNESS, add_force, column_force, deposit
from .indentation import SOLID_FIELDS, WINDOW, depth_in_column, pack_solid, shared_column, solid_of

_BISECTIONS = 9
_INSET = 1e-7
_ALONG = 1e-12


@njit(cache=True, error_model="numpy")
def press_bed(
    pad_place,
    pad_rotation,
    places,
    rotations,
    kinds,
    sizes,
    radii,
    laws,
    samples,
    masses,
    tables,
    steps,
    bed,
    dt,
    before,
    wrenches,
    stiffness,
    fine,
):
    """Press K simple solids into the bed.

    Parameters
    ----------
    pad_place, pad_rotation
        (3,) float64, m, and (9,) float64 row by row: the pad's frame in the world's.
    places, rotations
        (K, 3) and (K, 9) float64, the solids' frames in the world's.
    kinds, sizes, radii
        (K,) int32, (K, 3) and (K,) float64: kind of geom, its sizes, and its bounding radius, m.
    laws
        (K,) int32, row of `tables` that holds for each solid.
    samples
        (K,) int32, rows of samples laid over each solid, and samples in a row.
    masses
        (K,) float64, mass of the body that each belongs to, kg; inf if it cannot be moved.
    tables, steps
        (L, T) and (L,) float64, pressure over depth, Pa, and the depth between entries, m.
    bed
        (BED_FIELDS,) float64.
    dt
        Time since the last call, s; 0 if there was none.
    before
        (K, POSE_FIELDS) float64, poses of the last call in the pad's frame; overwritten.
    wrenches
        (K, 6) float64, overwritten by force (N) and torque about the pad's origin (N m) on each
        solid, in the pad's frame; what the last call left tells how strong friction may be.
    stiffness
        (K,) float64, overwritten by the bed's normal stiffness under each solid, N/m; what the
        last call left tells how strong the damping may be.
    fine
        (3, FINE * rows, FINE * columns) float64, overwritten by the force on each cell of the
        pad: normal, along x, along y, N.

    Returns
    -------
    int
        How many solids touch.
    """
    count = len(kinds)
    fine[:] = 0.0
    near = np.empty(count, np.int64)
    found = 0
    turned = np.empty((count, 3, 3))
    moved = np.empty((count, 3))
    windows = np.empty((count, WINDOW_FIELDS))
    solids = np.empty((count, SOLID_FIELDS))
    for k in range(count):
        into_pad(pad_place, pad_rotation, places[k], rotations[k], turned[k], moved[k])
        x, y, z, reach = moved[k, 0], moved[k, 1], moved[k, 2], radii[k]
        beside = abs(x) > bed[HALF_X] + reach or abs(y) > bed[HALF_Y] + reach
        if beside or z > reach or z < -reach - bed[THICKNESS]:
            continue
        if sunken_window(
            kinds[k], sizes[k], turned[k], moved[k], bed[HALF_X], bed[HALF_Y], windows[k]
        ):
            pack_solid(kinds[k], sizes[k], turned[k], moved[k], windows[k], solids[k])
            near[found] = k
            found += 1
    touching = 0
    others = np.empty(found, np.int64)
    twist = np.empty(6)
    for i in range(found):
        k = near[i]
        rivals = 0
        for j in range(found):
            if j != i and _overlap(windows[k], windows[near[j]]):
                others[rivals] = near[j]
                rivals += 1
        twist_since(turned[k], moved[k], before[k], dt, twist)
        loss_time, slip = calm_limits(bed, dt, wrenches[k], stiffness[k], masses[k])
        touching += _press_one(
            k,
            others[:rivals],
            solids,
            samples[k],
            tables[laws[k]],
            steps[laws[k]],
            bed,
            loss_time,
            slip,
            twist,
            wrenches[k],
            stiffness,
            fine,
        )
    _forget_and_remember(near[:found], turned, moved, before, wrenches, stiffness)
    return touching


@njit(cache=True, error_model="numpy")
def _forget_and_remember(near, turned, moved, before, wrenches, stiffness):
    for k in range(len(before)):
        before[k, 12] = 0.0
    for k in near:
        remember(turned[k], moved[k], before[k])
    for k in range(len(before)):
        if before[k, 12] == 0.0:
            wrenches[k] = 0.0
            stiffness[k] = 0.0


@njit(cache=True, error_model="numpy")
def _overlap(a, b):
    """Tell whether the upright rectangles around two windows meet."""
    ax, ay, aw, ah = _upright(a)
    bx, by, bw, bh = _upright(b)
    return abs(ax - bx) < aw + bw and abs(ay - by) < ah + bh


@njit(cache=True, error_model="numpy")
def _row_on_pad(window, v, half_x, half_y):
    """Ends of what of a window's row lies on the pad; the first is beyond the second if nothing."""
    ux, uy = window[AXIS_X], window[AXIS_Y]
    first, last = window[LOW_U], window[HIGH_U]
    for slope, start, half in ((ux, -uy * v, half_x), (uy, ux * v, half_y)):
        if abs(slope) > _ALONG:
            one, other = (-half - start) / slope, (half - start) / slope
            first, last = max(first, min(one, other)), min(last, max(one, other))
        elif abs(start) > half:
            return 1.0, -1.0
    return first, last


@njit(cache=True, error_model="numpy")
def _upright(window):
    ux, uy = window[AXIS_X], window[AXIS_Y]
    u, v = 0.5 * (window[LOW_U] + window[HIGH_U]), 0.5 * (window[LOW_V] + window[HIGH_V])
    a, b = 0.5 * (window[HIGH_U] - window[LOW_U]), 0.5 * (window[HIGH_V] - window[LOW_V])
    wide, high = a * abs(ux) + b * abs(uy), a * abs(uy) + b * abs(ux)
    return ux * u - uy * v, uy * u + ux * v, wide, high


@njit(cache=True, error_model="numpy")
def _row_end(solid, thickness, ux, uy, v, start, step, count):
    """March along a row to the first sample in contact and bisect back to where contact begins.

    Returns the place and whether there is any contact.
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
def _press_one(
    k,
    rivals,
    solids,
    count,
    table,
    step,
    bed,
    loss_time,
    slip,
    twist,
    wrench,
    stiffness,
    fine,
):
    solid = solid_of(solids, k)
    half_x, half_y, thickness = bed[HALF_X], bed[HALF_Y], bed[THICKNESS]
    wrench[:] = 0.0
    stiff = 0.0
    window = solids[k, WINDOW:]
    ux, uy = window[AXIS_X], window[AXIS_Y]
    height = (window[HIGH_V] - window[LOW_V]) / count
    # Round solids come out of the foam gradually: their contact's border needs no search.
    edged = solid[0] == BOX or solid[0] == CYLINDER
    for row in range(count):
        v = window[LOW_V] + (row + 0.5) * height
        first, last = _row_on_pad(window, v, half_x, half_y)
        if first >= last:
            continue
        if edged:
            step_u = (last - first) / count
            first, found = _row_end(solid, thickness, ux, uy, v, first, step_u, count)
            if not found:
                continue
            last, found = _row_end(solid, thickness, ux, uy, v, last, -step_u, count)
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
                depth, share = shared_column(depth, rivals, solids, thickness, x, y)
            sinking = -(twist[2] + twist[3] * y - twist[4] * x)
            slide_x = twist[0] - twist[4] * depth - twist[5] * y
            slide_y = twist[1] + twist[3] * depth + twist[5] * x
            fz, fx, fy, slope = column_force(
                depth, sinking, slide_x, slide_y, share * area, table, step, bed, loss_time, slip
            )
            add_force(wrench, x, y, depth, fx, fy, fz)
            stiff += slope
            deposit(fine, bed, x, y, fz, -fx, -fy)
    stiffness[k] = stiff
    return 1 if wrench[2] > 0.0 else 0

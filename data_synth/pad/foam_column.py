"""What one column of foam does to the solid in it, and where the pad feels it: compiled."""

from __future__ import annotations

from math import floor, sqrt

from numba import njit

HALF_X, HALF_Y, THICKNESS, LOSS_TIME, FRICTION, SLIP_SPEED = 0, 1, 2, 3, 4, 5
"""Fields of the bed: half its extents and its height, m; the loss time, s; the coefficient of
friction; the speed at which friction is full, m/s."""
BED_FIELDS = 6
"""How many there are."""
FINE = 2
"""Cells of the fine grid per tactel, each way; the samples' forces are gathered on it."""


@njit(cache=True, error_model="numpy")
def column_force(depth, sinking, slide_x, slide_y, area, table, step, bed, loss_time, slip):
    """Push of one column on the solid in it.

    Parameters
    ----------
    depth, sinking
        How deep the surface is, m, > 0, and its rate, m/s.
    slide_x, slide_y
        Velocity of the solid along the pad, m/s.
    area
        Of the column, m².
    table, step
        The law (see :func:`table_pressure`).
    bed
        (BED_FIELDS,) float64.
    loss_time
        Damping over stiffness, s.
    slip
        Speed at which friction is full, m/s.

    Returns
    -------
    tuple of four floats
        Force along z, x, y, N, and stiffness, N/m. The foam's loss acts as a damper whose
        constant is the stiffness times the loss time, and the foam never pulls. Friction is
        Coulomb's, smoothed to f = mu p v / sqrt(v² + slip²).
    """
    pressure, slope = table_pressure(table, step, depth)
    pressure = max(pressure + loss_time * slope * sinking, 0.0)
    push = pressure * area
    grip = -bed[FRICTION] * push / sqrt(slide_x * slide_x + slide_y * slide_y + slip * slip)
    return push, grip * slide_x, grip * slide_y, slope * area


@njit(cache=True, error_model="numpy")
def deposit(fine, bed, x, y, along_z, along_x, along_y):
    """Share a sample's force among 3x3 cells of the fine grid.

    The weights are the quadratic B-spline's: force and centre are kept, and the blur is the same
    wherever between cell centres the sample lies. What would leave the pad is folded back at its
    border, as nothing but the pad bears it.
    """
    rows, columns = fine.shape[1], fine.shape[2]
    place_x = (x + bed[HALF_X]) / (2.0 * bed[HALF_X]) * columns
    place_y = (y + bed[HALF_Y]) / (2.0 * bed[HALF_Y]) * rows
    column = min(max(floor(place_x), 0), columns - 1)
    row = min(max(floor(place_y), 0), rows - 1)
    a, b = place_x - column - 0.5, place_y - row - 0.5
    weights_x = (0.5 * (0.5 - a) ** 2, 0.75 - a * a, 0.5 * (0.5 + a) ** 2)
    weights_y = (0.5 * (0.5 - b) ** 2, 0.75 - b * b, 0.5 * (0.5 + b) ** 2)
    sheared = along_x != 0.0 or along_y != 0.0
    for p in range(3):
        r = min(max(row + p - 1, 0), rows - 1)
        for q in range(3):
            c = min(max(column + q - 1, 0), columns - 1)
            weight = weights_y[p] * weights_x[q]
            fine[0, r, c] += weight * along_z
            if sheared:
                fine[1, r, c] += weight * along_x
                fine[2, r, c] += weight * along_y


@njit(cache=True, error_model="numpy")
def table_pressure(table, step, depth):
    """Look up pressure, Pa, and its slope, Pa/m, at a depth > 0, m."""
    cell = int(depth / step)
    last = len(table) - 2
    if cell > last:
        cell = last
    slope = (table[cell + 1] - table[cell]) / step
    return table[cell] + slope * (depth - cell * step), slope


@njit(cache=True, error_model="numpy")
def add_force(wrench, x, y, depth, fx, fy, fz):
    """Add a force at (x, y, -depth) to a wrench (6,) about the origin."""
    wrench[0] += fx
    wrench[1] += fy
    wrench[2] += fz
    wrench[3] += y * fz + depth * fy
    wrench[4] -= depth * fx + x * fz
    wrench[5] += x * fy - y * fx

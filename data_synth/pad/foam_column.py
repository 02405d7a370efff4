"""The force of one foam column on a solid, and on the pad's grid (compiled)."""

from __future__ import annotations

from math import floor, sqrt

from numba import njit

HALF_X, HALF_Y, THICKNESS, LOSS_TIME, FRICTION, SLIP_SPEED, SHEAR_STIFFNESS = range(7)
"""Fields of the bed: half its extents and its height, m; the loss time, s; the coefficient of
friction; the slip speed, m/s; the shear stiffness per area, Pa/m, 0 for viscous friction."""
CELLS_PER_TACTEL = 2
"""Cells of the force grid per tactel, along x and along y."""


@njit(cache=True, error_model="numpy")
def column_force(depth, x, y, area, law, bed):
    """Compute the force of one column on the solid in it.

    The foam's loss acts as a damper whose constant is the stiffness times the loss time. The foam
    never pulls. Friction is Coulomb's, smoothed to f = mu p v / sqrt(v² + slip²).

    Parameters
    ----------
    depth
        Depth of the solid's surface in the foam, m, > 0.
    x, y
        Position of the column on the pad, m.
    area
        Cross-section of the column, m².
    law
        :class:`ColumnLaw`.
    bed
        (BED_FIELDS,) float64.

    Returns
    -------
    tuple of four floats
        Force along z, x and y, N, and stiffness, N/m.
    """
    twist = law.twist
    sinking = -(twist[2] + twist[3] * y - twist[4] * x)
    slide_x, slide_y = slide_at(twist, x, y, depth)
    pressure, slope = table_pressure(law.table, law.step, depth)
    pressure = max(pressure + law.loss_time * slope * sinking, 0.0)
    push = pressure * area
    slip = law.slip
    grip = -bed[FRICTION] * push / sqrt(slide_x * slide_x + slide_y * slide_y + slip * slip)
    return push, grip * slide_x, grip * slide_y, slope * area


@njit(cache=True, error_model="numpy")
def slide_at(twist, x, y, depth):
    """Return the velocity along x and y, m/s, of a solid's point at (x, y, -depth)."""
    return twist[0] - twist[4] * depth - twist[5] * y, twist[1] + twist[3] * depth + twist[5] * x


@njit(cache=True, error_model="numpy")
def deposit(grid, bed, x, y, along_z, along_x, along_y):
    """Add the force at (x, y) to 3x3 cells of the force grid (3, rows, columns).

    The weights are those of a quadratic B-spline. They keep force and centre, and the blur does not
    depend on the place between cell centres. Force beyond the border is folded back onto the pad,
    because nothing else bears it.
    """
    rows, columns = grid.shape[1], grid.shape[2]
    row, column, weights_x, weights_y = spline_weights(bed, rows, columns, x, y)
    sheared = along_x != 0.0 or along_y != 0.0
    for p in range(3):
        r = min(max(row + p - 1, 0), rows - 1)
        for q in range(3):
            c = min(max(column + q - 1, 0), columns - 1)
            weight = weights_y[p] * weights_x[q]
            grid[0, r, c] += weight * along_z
            if sheared:
                grid[1, r, c] += weight * along_x
                grid[2, r, c] += weight * along_y


@njit(cache=True, error_model="numpy")
def spline_weights(bed, rows, columns, x, y):
    """Return the middle cell (row, column) of the 3x3 cells around (x, y), and their weights."""
    place_x = (x + bed[HALF_X]) / (2.0 * bed[HALF_X]) * columns
    place_y = (y + bed[HALF_Y]) / (2.0 * bed[HALF_Y]) * rows
    column = min(max(floor(place_x), 0), columns - 1)
    row = min(max(floor(place_y), 0), rows - 1)
    a, b = place_x - column - 0.5, place_y - row - 0.5
    weights_x = (0.5 * (0.5 - a) ** 2, 0.75 - a * a, 0.5 * (0.5 + a) ** 2)
    weights_y = (0.5 * (0.5 - b) ** 2, 0.75 - b * b, 0.5 * (0.5 + b) ** 2)
    return row, column, weights_x, weights_y


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

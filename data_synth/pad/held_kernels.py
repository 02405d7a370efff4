"""Motion of an object held between two equal pads, and the forces on one of them (compiled).

The object moves in the plane of the pads: it slides along both and turns about their normal. The
grip force is given. Each cell of the pad is a bristle, as in :mod:`bristles`. The object's surface
is rough: its height and its friction vary over the face, and move with the object.
"""

from __future__ import annotations

from math import cos, floor, sin, sqrt
from typing import NamedTuple

from numba import njit
from numpy.typing import NDArray

from .bristles import friction_limit
from .foam_column import HALF_X, HALF_Y, LOSS_TIME, SHEAR_STIFFNESS, table_pressure

X, Y, ANGLE, SPEED_X, SPEED_Y, SPIN, DEPTH, SLIDE, SLIPPING, PUSH = range(10)
"""Fields of the motion: place (m), angle (rad), their rates, depth of the face in the foam (m), the
path that the face has slid over the foam (m, mean over the cells by force), the share of the
normal force on cells that slide, and the normal force (N)."""
MOTION_SIZE = 10
GRIP, FORCE_X, FORCE_Y, TORQUE = range(4)
"""Fields of the drive: the grip force (N), and the load on the object at its centre of mass (N,
N m)."""
PADS = 2
"""Number of pads that hold the object; both move it alike."""
_SLIPPING_STEP = 1e-9
"""Slide of a bristle in one step from which it counts as sliding, m."""
_MARGIN = 2
"""Cells around the face that are cleared when it has left them."""
_MIN_SLOPE = 1.0
"""Least stiffness by which the depth is corrected, N/m."""


class HeldBody(NamedTuple):
    """The held object, as the kernel reads it."""

    mass: float
    """kg."""
    inertia: float
    """Moment of inertia about the pads' normal at the centre of mass, kg m²."""
    centre_x: float
    """Centre of mass from the middle of the face, along the object's x, m."""
    centre_y: float
    """Along the object's y, m."""
    half_x: float
    """Half the face's extent along x, m."""
    half_y: float
    """Along y, m."""
    curve_x: float
    """Curvature of the face along x, 1/m; 0 is flat."""
    curve_y: float
    """Along y, 1/m."""
    roughness: NDArray
    """(2, n, n), n a power of 2: height, m, and factor of the friction, over one period."""
    texture_cell: float
    """Distance of two entries of `roughness`, m."""


@njit(cache=True, error_model="numpy")
def advance_held(body, law, bed, drive, steps, motion, grid, bends):
    """Advance the object by one image.

    Parameters
    ----------
    body
        :class:`HeldBody`.
    law
        Pressures over the depth, Pa, their step, m, and the duration of a step, s.
    bed
        (BED_FIELDS,) float64 (see :mod:`foam_column`).
    drive
        (2, 4) float64: the drive at the start and at the end.
    steps
        Number of steps, >= 1.
    motion
        (MOTION_SIZE,) float64, updated.
    grid
        (3, rows, columns) float64, overwritten: forces on one pad at the end, N.
    bends
        (3, rows, columns) float64, updated: how far each bristle is bent along x and y, m, and the
        speed at which its end slid in the last step, m/s. A bristle that bends without sliding has
        static friction.
    """
    dt = law[2]
    for step in range(steps):
        share = (step + 1.0) / steps
        grip = drive[0, GRIP] + share * (drive[1, GRIP] - drive[0, GRIP])
        load_x = drive[0, FORCE_X] + share * (drive[1, FORCE_X] - drive[0, FORCE_X])
        load_y = drive[0, FORCE_Y] + share * (drive[1, FORCE_Y] - drive[0, FORCE_Y])
        load_turn = drive[0, TORQUE] + share * (drive[1, TORQUE] - drive[0, TORQUE])
        push, slope, force_x, force_y, turn = _press(body, law, bed, motion, grid, bends)
        motion[DEPTH] = max(motion[DEPTH] + (grip - push) / max(slope, _MIN_SLOPE), 0.0)
        motion[SPEED_X] += dt * (load_x + PADS * force_x) / body.mass
        motion[SPEED_Y] += dt * (load_y + PADS * force_y) / body.mass
        motion[SPIN] += dt * (load_turn + PADS * turn) / body.inertia
        motion[X] += dt * motion[SPEED_X]
        motion[Y] += dt * motion[SPEED_Y]
        motion[ANGLE] += dt * motion[SPIN]


@njit(cache=True, error_model="numpy")
def _press(body, law, bed, motion, grid, bends):
    """Press the face into the foam, and return force, stiffness, friction and torque.

    The motion's place and speed are those of the centre of mass.
    """
    table, table_step, dt = law
    rows, columns = grid.shape[1], grid.shape[2]
    cell_x, cell_y = 2.0 * bed[HALF_X] / columns, 2.0 * bed[HALF_Y] / rows
    area = cell_x * cell_y
    cosine, sine = cos(motion[ANGLE]), sin(motion[ANGLE])
    stiff = bed[SHEAR_STIFFNESS] * area
    lead = dt + bed[LOSS_TIME]
    push, slope, force_x, force_y, turn, slid, slipping = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    reach = sqrt((body.half_x + abs(body.centre_x)) ** 2 + (body.half_y + abs(body.centre_y)) ** 2)
    top, bottom = _reached(rows, cell_y, motion[Y], reach)
    left, right = _reached(columns, cell_x, motion[X], reach)
    for r in range(top, bottom):
        away_y = (r + 0.5) * cell_y - bed[HALF_Y] - motion[Y]
        for c in range(left, right):
            away_x = (c + 0.5) * cell_x - bed[HALF_X] - motion[X]
            x = cosine * away_x + sine * away_y + body.centre_x
            y = cosine * away_y - sine * away_x + body.centre_y
            depth, factor = 0.0, 1.0
            covered = _covered(body.half_x, x, cell_x) * _covered(body.half_y, y, cell_y)
            if covered > 0.0:
                high, factor = _texture(body, x, y)
                depth = motion[DEPTH] + high
                depth -= 0.5 * (body.curve_x * x * x + body.curve_y * y * y)
            if depth <= 0.0:
                bends[:, r, c] = 0.0
                grid[0, r, c], grid[1, r, c], grid[2, r, c] = 0.0, 0.0, 0.0
                continue
            pressure, rise = table_pressure(table, table_step, depth)
            normal = pressure * covered * area
            hold = stiff * covered
            speed_x = motion[SPEED_X] - motion[SPIN] * away_y
            speed_y = motion[SPEED_Y] + motion[SPIN] * away_x
            limit = friction_limit(bed, bends[2, r, c]) * factor * normal / hold
            bend_x, bend_y = bends[0, r, c] + speed_x * dt, bends[1, r, c] + speed_y * dt
            bend = sqrt(bend_x * bend_x + bend_y * bend_y)
            bends[2, r, c] = max(bend - limit, 0.0) / dt if dt > 0.0 else 0.0
            if bend > limit:
                slid += normal * (bend - limit)
                slipping += normal if bend - limit > _SLIPPING_STEP else 0.0
                bend_x, bend_y = bend_x * limit / bend, bend_y * limit / bend
            bends[0, r, c], bends[1, r, c] = bend_x, bend_y
            along_x, along_y = bend_x + lead * speed_x, bend_y + lead * speed_y
            bend = sqrt(along_x * along_x + along_y * along_y)
            if bend > limit:
                along_x, along_y = along_x * limit / bend, along_y * limit / bend
            along_x, along_y = -hold * along_x, -hold * along_y
            grid[0, r, c], grid[1, r, c], grid[2, r, c] = normal, -along_x, -along_y
            push += normal
            slope += rise * covered * area
            force_x += along_x
            force_y += along_y
            turn += away_x * along_y - away_y * along_x
    if push > 0.0:
        motion[SLIDE] += slid / push
        motion[SLIPPING] = slipping / push
    else:
        # Nothing holds the object: all of its path is slide.
        motion[SLIDE] += dt * sqrt(motion[SPEED_X] ** 2 + motion[SPEED_Y] ** 2)
        motion[SLIPPING] = 1.0
    motion[PUSH] = push
    return push, slope, force_x, force_y, turn


@njit(cache=True, error_model="numpy")
def _reached(cells, cell, place, reach):
    """Return the first cell, and that after the last, that the face reaches or has just left."""
    middle = place / cell + 0.5 * cells
    first = floor(middle - reach / cell) - _MARGIN
    last = floor(middle + reach / cell) + _MARGIN
    return min(max(first, 0), cells), min(max(last + 1, 0), cells)


@njit(cache=True, error_model="numpy")
def _covered(half, place, cell):
    """Return the share of a cell's width that the face covers, so that its rim moves smoothly."""
    return min(max((half - abs(place)) / cell + 0.5, 0.0), 1.0)


@njit(cache=True, error_model="numpy")
def _texture(body, x, y):
    """Return height, m, and friction factor of the surface, linear between the entries."""
    table = body.roughness
    mask = table.shape[1] - 1
    place_x, place_y = x / body.texture_cell, y / body.texture_cell
    low_x, low_y = floor(place_x), floor(place_y)
    a, b = place_x - low_x, place_y - low_y
    left, right, low, high = low_x & mask, (low_x + 1) & mask, low_y & mask, (low_y + 1) & mask
    first, second, third, fourth = (1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b
    height = first * table[0, low, left] + second * table[0, low, right]
    height += third * table[0, high, left] + fourth * table[0, high, right]
    factor = first * table[1, low, left] + second * table[1, low, right]
    factor += third * table[1, high, left] + fourth * table[1, high, right]
    return height, factor

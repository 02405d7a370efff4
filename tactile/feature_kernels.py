"""Raw readings to pressures to features, compiled: one call per cycle of the servo."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from .moments import long_axis
from .region import find_region

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .image import TactileArray

TRUSTED, SATURATED, DEAD = 0, 1, 2
"""What a reading is worth: as measured; at least so much; nothing, so its neighbours' mean."""
VALUES = 15
"""Numbers that :func:`describe` gives: force, centre (3), area, orientation, confidence,
normal (3), tactels, share of force on the border, saturated, interpolated, contact found."""


def pack_geometry(array: TactileArray) -> NDArray[np.float64]:
    """Position (3), normal (3), area, and 1 on the border, of every tactel, (N, 8)."""
    border = array.border.astype(np.float64)
    return np.column_stack([array.positions, array.normals, array.areas, border])


@njit(cache=True)
def read_pressures(raw, table, limits, links, geometry, pressures, states):
    """Fill pressures (N,) Pa and states (N,) uint8 from raw readings (N,).

    Parameters
    ----------
    table
        (N, levels) float32: pressure of every tactel at every reading, Pa.
    limits
        (N, 2) int32: below the first a tactel is dead, from the second on saturated.
    links, geometry
        As `pack_links` and :func:`pack_geometry` give them. A dead tactel gets the mean of its
        live neighbours, weighted by 1 / distance², or 0 where all of them are dead.
    """
    count, top = len(raw), table.shape[1] - 1
    dead = 0
    for tactel in range(count):
        reading = min(int(raw[tactel]), top)
        if reading < limits[tactel, 0]:
            states[tactel] = DEAD
            dead += 1
            continue
        pressures[tactel] = table[tactel, reading]
        states[tactel] = SATURATED if reading >= limits[tactel, 1] else TRUSTED
    if dead == 0:
        return
    for tactel in range(count):
        if states[tactel] != DEAD:
            continue
        total, weights = 0.0, 0.0
        for link in range(links[tactel], links[tactel + 1]):
            other = links[link]
            if states[other] == DEAD:
                continue
            square = 0.0
            for axis in range(3):
                square += (geometry[tactel, axis] - geometry[other, axis]) ** 2
            total += pressures[other] / square
            weights += 1.0 / square
        pressures[tactel] = total / weights if weights > 0.0 else 0.0


@njit(cache=True)
def describe(
    pressures, states, thresholds, links, geometry, previous, hysteresis, min_tactels, rim, members,
    values,
):  # fmt: skip
    """Fill the features of the contact region into `values` (VALUES,), and count its tactels.

    Parameters
    ----------
    pressures, states, thresholds
        (N,) each.
    links, geometry, previous, hysteresis, members
        As in `find_region`.
    min_tactels
        Regions with fewer tactels are no contact: the count is then 0, and so is every value.
    rim
        A tactel counts fully in the area from (1 + `rim`) times its threshold on, and less and
        less down to none at the threshold; the region's highest always counts fully.
    """
    values[:] = 0.0
    values[9] = 1.0
    size = find_region(pressures, thresholds, links, geometry, previous, hysteresis, members)
    if size < min_tactels:
        return 0
    highest = 0.0
    for k in range(size):
        highest = max(highest, pressures[members[k]] - thresholds[members[k]])
    force, area, border = 0.0, 0.0, 0.0
    weights = np.empty(size)
    for k in range(size):
        tactel = members[k]
        share = pressures[tactel] * geometry[tactel, 6]
        weights[k] = share
        force += share
        over = pressures[tactel] - thresholds[tactel]
        full = min(rim * thresholds[tactel], highest)
        area += geometry[tactel, 6] * (over / full if over < full else 1.0)
        border += share * geometry[tactel, 7]
        for axis in range(3):
            values[1 + axis] += share * geometry[tactel, axis]
            values[7 + axis] += share * geometry[tactel, 3 + axis]
        values[12] += states[tactel] == SATURATED
        values[13] += states[tactel] == DEAD
    if not force > 0.0:
        values[:] = 0.0
        values[9] = 1.0
        return 0
    values[9] -= 1.0
    length = math.sqrt(values[7] ** 2 + values[8] ** 2 + values[9] ** 2)
    for axis in range(3):
        values[1 + axis] /= force
        # Normals all around a ball cancel: there is no tangent plane then but the sensor's.
        values[7 + axis] = values[7 + axis] / length if length > 0.0 else axis // 2
    values[0], values[4] = force, area
    # A single tactel has no direction, but rounding gives it second moments, and those a sure one.
    if size > 1:
        x, y = np.empty(size), np.empty(size)
        _project(geometry, members, size, values[7:10], x, y)
        values[5], values[6] = long_axis(x, y, weights, size)
    values[10], values[11], values[14] = size, border / force, 1.0
    return size


@njit(cache=True)
def read_features(
    raw,
    table,
    limits,
    thresholds,
    links,
    geometry,
    previous,
    hysteresis,
    min_tactels,
    rim,
    pressures,
    states,
    members,
    values,
):
    """Do :func:`read_pressures` and :func:`describe`, and keep the centre in `previous`."""
    read_pressures(raw, table, limits, links, geometry, pressures, states)
    size = describe(
        pressures,
        states,
        thresholds,
        links,
        geometry,
        previous,
        hysteresis,
        min_tactels,
        rim,
        members,
        values,
    )
    for axis in range(3):
        previous[axis] = values[1 + axis] if size > 0 else np.nan
    return size


@njit(cache=True)
def _project(geometry, members, size, normal, x, y):
    """Coordinates in the plane of `normal`, whose axes are those of `image.tangents`."""
    a, b, c = normal
    if c <= -1.0 + 1e-12:
        for k in range(size):
            x[k], y[k] = geometry[members[k], 0], -geometry[members[k], 1]
        return
    d = 1.0 / (1.0 + c)
    xx, xy, yy = 1.0 - a * a * d, -a * b * d, 1.0 - b * b * d
    for k in range(size):
        px, py, pz = geometry[members[k], 0], geometry[members[k], 1], geometry[members[k], 2]
        x[k] = xx * px + xy * py - a * pz
        y[k] = xy * px + yy * py - b * pz

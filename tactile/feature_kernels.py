"""From raw readings to pressures to contact features, in one compiled call per servo cycle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple

from .moments import long_axis
from .region import find_region

if TYPE_CHECKING:
    from numpy.typing import NDArray

TRUSTED, SATURATED, DEAD = 0, 1, 2
"""State of a reading: valid; a lower bound; invalid, replaced by the mean of its neighbours."""
VALUES = 15
"""Number of computed values: force, centre (3), area, orientation, confidence, normal (3), tactels,
share of the force at the border, saturated, interpolated, and whether there is a contact."""


class Rule(NamedTuple):
    """The fields of `FeatureOptions` that define a contact, in one array."""

    hysteresis: float
    """Share of tactels."""
    min_tactels: float
    """Smallest region."""
    rim_band: float
    """Multiple of the threshold."""


class Buffers(NamedTuple):
    """Results and memory of a reader."""

    pressures: NDArray[np.float64]
    """(N,), Pa."""
    states: NDArray[np.uint8]
    """(N,), `TRUSTED`, `SATURATED` or `DEAD`."""
    members: NDArray[np.int32]
    """(N,), starts with the tactels of the contact region."""
    values: NDArray[np.float64]
    """(VALUES,), the features."""
    previous: NDArray[np.float64]
    """(3,), centre of the last contact, m; NaN without one."""


@njit(cache=True)
def read_pressures(raw, table, limits, links, geometry, pressures, states):
    """Convert raw readings (N,) to pressures (N,) Pa and states (N,) uint8.

    A dead tactel gets the mean of its working neighbours, weighted by 1 / distance², or 0 if there
    are none.

    Parameters
    ----------
    table
        (N, levels) float32, pressure of each tactel at every reading, Pa.
    limits
        (N, 2) int32: a reading below the first is dead, from the second on saturated.
    links, geometry
        Of the `TactileArray`.
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
def compute_features(thresholds, links, geometry, rule, buffers):
    """Compute the features of the contact region from `buffers.pressures`, eqs. (11) and (12).

    Parameters
    ----------
    thresholds
        (N,), Pa.
    links, geometry
        Of the `TactileArray`.
    rule
        The values of `Rule` as an array (3,).
    buffers
        The values of `Buffers` as a plain tuple. Numba needs 9 µs to accept a named tuple from
        Python, but less than 0.1 µs for a plain one.

    Returns
    -------
    int
        Number of tactels in the region, at the start of `buffers.members`; 0 without a contact.
        All values are then 0.
    """
    rule = Rule(*to_fixed_tuple(rule, 3))  # pyright: ignore[reportCallIssue] - numba fills in the typing context
    return _describe(thresholds, links, geometry, rule, Buffers(*buffers))


@njit(cache=True)
def read_features(raw, table, limits, thresholds, links, geometry, rule, buffers):
    """Convert raw readings to features, and store the centre as `buffers.previous`.

    The parameters are those of :func:`read_pressures` and :func:`compute_features`.
    """
    b = Buffers(*buffers)
    read_pressures(raw, table, limits, links, geometry, b.pressures, b.states)
    rule = Rule(*to_fixed_tuple(rule, 3))  # pyright: ignore[reportCallIssue] - numba fills in the typing context
    size = _describe(thresholds, links, geometry, rule, b)
    for axis in range(3):
        b.previous[axis] = b.values[1 + axis] if size > 0 else np.nan
    return size


@njit(cache=True)
def _describe(thresholds, links, geometry, rule, buffers):
    pressures, members, values = buffers.pressures, buffers.members, buffers.values
    values[:] = 0.0
    values[9] = 1.0
    size = find_region(
        pressures, thresholds, links, geometry, buffers.previous, rule.hysteresis, members
    )
    if size < rule.min_tactels:
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
        full = min(rule.rim_band * thresholds[tactel], highest)
        area += geometry[tactel, 6] * (over / full if over < full else 1.0)
        border += share * geometry[tactel, 7]
        for axis in range(3):
            values[1 + axis] += share * geometry[tactel, axis]
            values[7 + axis] += share * geometry[tactel, 3 + axis]
        values[12] += buffers.states[tactel] == SATURATED
        values[13] += buffers.states[tactel] == DEAD
    if not force > 0.0:
        values[:] = 0.0
        values[9] = 1.0
        return 0
    values[9] -= 1.0
    length = math.sqrt(values[7] ** 2 + values[8] ** 2 + values[9] ** 2)
    for axis in range(3):
        values[1 + axis] /= force
        # Normals all around a sphere cancel. The sensor's z-axis then stands in for their mean.
        values[7 + axis] = values[7 + axis] / length if length > 0.0 else axis // 2
    values[0], values[4] = force, area
    # The second moments of a single tactel are rounding errors.
    if size > 1:
        x, y = np.empty(size), np.empty(size)
        _project(geometry, members, size, values[7:10], x, y)
        values[5], values[6] = long_axis(x, y, weights, size)
    values[10], values[11], values[14] = size, border / force, 1.0
    return size


@njit(cache=True)
def _project(geometry, members, size, normal, x, y):
    """Compute coordinates in the plane of `normal`, along the axes of `image.tangents`."""
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

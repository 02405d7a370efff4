"""Convert raw readings to pressures and contact features, in one compiled call per servo cycle."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from .curve_kernels import curve_pressure
from .moments import long_axis
from .region import find_region

TRUSTED, SATURATED, DEAD = 0, 1, 2
"""State of a reading. TRUSTED: valid. SATURATED: a lower bound of the true pressure. DEAD: invalid,
replaced by the mean of its neighbours."""
FORCE, CENTRE, AREA, ORIENTATION, CONFIDENCE, NORMAL = 0, 1, 4, 5, 6, 7
"""Indices of the feature values. The centre and the normal have three values each."""
TACTEL_COUNT, BORDER_SHARE, SATURATED_COUNT, DEAD_COUNT, HAS_CONTACT = range(10, 15)
"""Indices of the other feature values."""
VALUE_COUNT = 15
"""Number of feature values."""


class ContactRule(NamedTuple):
    """The options that a compiled function needs to select and describe a contact region."""

    hysteresis: float
    """`FeatureOptions.hysteresis`."""
    min_tactels: float
    """Minimum number of tactels of a contact."""
    rim_band: float
    """`FeatureOptions.rim_band`."""


class Buffers(NamedTuple):
    """Arrays that a `FeatureReader` reuses: its results and the last contact."""

    pressures: NDArray[np.float64]
    """Pressures, (N,), Pa."""
    states: NDArray[np.uint8]
    """State of each reading, (N,): `TRUSTED`, `SATURATED` or `DEAD`."""
    members: NDArray[np.int32]
    """(N,): its first entries are the indices of the contact region's tactels."""
    values: NDArray[np.float64]
    """Feature values, (VALUE_COUNT,)."""
    previous: NDArray[np.float64]
    """Centre of the last contact, (3,), m; NaN if there was none."""


@njit(cache=True)
def read_pressures(raw, curves, limits, links, geometry, pressures, states):
    """Convert raw readings (N,) to pressures (N,) Pa and states (N,) uint8.

    The pressure of a dead tactel is the mean of its working neighbours, weighted by 1 / distance².
    It is 0 if there are none.

    Parameters
    ----------
    curves
        `Calibration.curves`, (N, K, 3).
    limits
        (N, 2) int32. A reading below the first value is dead. A reading at or above the second
        value is saturated.
    links, geometry
        `TactileArray.links` and `TactileArray.geometry`.
    pressures, states
        Outputs, see `Buffers`.
    """
    count = len(raw)
    dead = 0
    for tactel in range(count):
        reading = int(raw[tactel])
        if reading < limits[tactel, 0]:
            states[tactel] = DEAD
            dead += 1
            continue
        pressures[tactel] = curve_pressure(curves, tactel, float(reading))
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
            squared_distance = 0.0
            for axis in range(3):
                squared_distance += (geometry[tactel, axis] - geometry[other, axis]) ** 2
            total += pressures[other] / squared_distance
            weights += 1.0 / squared_distance
        pressures[tactel] = total / weights if weights > 0.0 else 0.0


@njit(cache=True)
def compute_features(thresholds, links, geometry, rule, buffers):
    """Compute the features of the contact region from `buffers.pressures`.

    Force and centre follow eq. (11) of Haschke's chapter. Eq. (12) is extended: the area of a
    tactel grows smoothly above its threshold, see `FeatureOptions.rim_band`.

    Parameters
    ----------
    thresholds
        Pressure above which each tactel counts as touched, (N,), Pa.
    links, geometry
        `TactileArray.links` and `TactileArray.geometry`. Columns of `geometry`: position (3),
        normal (3), area, 1 on the border.
    rule
        The values of `ContactRule` as an array (3,).
    buffers
        The values of `Buffers` as a plain tuple. Numba needs 9 µs to accept a named tuple from
        Python, but less than 0.1 µs for a plain one.

    Returns
    -------
    int
        Number of tactels of the region, 0 without a contact. Their indices are the first entries
        of `buffers.members`. Without a contact all values are 0, except the normal (0, 0, 1).
    """
    rule = ContactRule(*to_fixed_tuple(rule, 3))  # pyright: ignore[reportCallIssue] - numba passes the first argument itself
    return _describe(thresholds, links, geometry, rule, Buffers(*buffers))


@njit(cache=True)
def read_features(raw, curves, limits, thresholds, links, geometry, rule, buffers):
    """Convert raw readings to features, and store the centre as `buffers.previous`.

    Without a contact, the stored centre is NaN.

    The parameters are those of :func:`read_pressures` and :func:`compute_features`.
    """
    b = Buffers(*buffers)
    read_pressures(raw, curves, limits, links, geometry, b.pressures, b.states)
    rule = ContactRule(*to_fixed_tuple(rule, 3))  # pyright: ignore[reportCallIssue] - numba passes the first argument itself
    size = _describe(thresholds, links, geometry, rule, b)
    for axis in range(3):
        b.previous[axis] = b.values[CENTRE + axis] if size > 0 else np.nan
    return size


@njit(cache=True)
def _describe(thresholds, links, geometry, rule, buffers):
    """Compute the feature values; return the number of tactels in the contact region."""
    pressures, members, values = buffers.pressures, buffers.members, buffers.values
    values[:] = 0.0
    # The normal without a contact is (0, 0, 1). The 1 is subtracted again after the summation.
    values[NORMAL + 2] = 1.0
    size = find_region(
        pressures, thresholds, links, geometry, buffers.previous, rule.hysteresis, members
    )
    if size < rule.min_tactels:
        return 0
    max_excess = 0.0
    for k in range(size):
        max_excess = max(max_excess, pressures[members[k]] - thresholds[members[k]])
    force, area, border = 0.0, 0.0, 0.0
    weights = np.empty(size)
    for k in range(size):
        tactel = members[k]
        tactel_force = pressures[tactel] * geometry[tactel, 6]
        weights[k] = tactel_force
        force += tactel_force
        excess = pressures[tactel] - thresholds[tactel]
        full_excess = min(rule.rim_band * thresholds[tactel], max_excess)
        area += geometry[tactel, 6] * (excess / full_excess if excess < full_excess else 1.0)
        border += tactel_force * geometry[tactel, 7]
        for axis in range(3):
            values[CENTRE + axis] += tactel_force * geometry[tactel, axis]
            values[NORMAL + axis] += tactel_force * geometry[tactel, 3 + axis]
        values[SATURATED_COUNT] += buffers.states[tactel] == SATURATED
        values[DEAD_COUNT] += buffers.states[tactel] == DEAD
    if not force > 0.0:
        values[:] = 0.0
        values[NORMAL + 2] = 1.0
        return 0
    values[NORMAL + 2] -= 1.0
    normal = values[NORMAL : NORMAL + 3]
    length = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    for axis in range(3):
        values[CENTRE + axis] /= force
        # Normals all around a sphere cancel. Their mean is then undefined: use the sensor's z-axis.
        normal[axis] = normal[axis] / length if length > 0.0 else (0.0, 0.0, 1.0)[axis]
    values[FORCE], values[AREA] = force, area
    # The second moments of a single tactel are rounding errors.
    if size > 1:
        x, y = np.empty(size), np.empty(size)
        _project(geometry, members, size, normal, x, y)
        values[ORIENTATION], values[CONFIDENCE] = long_axis(x, y, weights, size)
    values[TACTEL_COUNT], values[BORDER_SHARE], values[HAS_CONTACT] = size, border / force, 1.0
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

"""Compiled curves from reading to pressure: monotone means, monotone cubics, and their values."""

from __future__ import annotations

import numpy as np
from numba import njit

RAW, PRESSURE, SLOPE = range(3)
"""Fields of a knot: reading, counts; pressure, Pa; and slope there, Pa per count."""


@njit(cache=True)
def make_monotone(values, weights):
    """Replace each row of `values` (N, K) by its weighted isotonic regression, in place.

    It equals `scipy.optimize.isotonic_regression` row by row, which takes 1.3 s for 76,800 rows of
    64 values; this function takes 0.03 s.
    """
    rows, count = values.shape
    means, totals = np.empty(count), np.empty(count)
    sizes = np.empty(count, np.int64)
    for row in range(rows):
        blocks = 0
        for k in range(count):
            means[blocks], totals[blocks], sizes[blocks] = values[row, k], weights[k], 1
            blocks += 1
            while blocks > 1 and means[blocks - 2] >= means[blocks - 1]:
                total = totals[blocks - 2] + totals[blocks - 1]
                mean = means[blocks - 2] * totals[blocks - 2]
                mean += means[blocks - 1] * totals[blocks - 1]
                means[blocks - 2], totals[blocks - 2] = mean / total, total
                sizes[blocks - 2] += sizes[blocks - 1]
                blocks -= 1
        k = 0
        for block in range(blocks):
            values[row, k : k + sizes[block]] = means[block]
            k += sizes[block]


@njit(cache=True)
def rest_noise(raw, expected, pressures, knots):
    """Return the standard deviation of readings (M, N) about their tactel's curve, (N,), counts.

    Parameters
    ----------
    raw
        Readings, (M, N).
    expected, knots
        Curves (N, K), counts, at the pressures `knots` (K,), Pa.
    pressures
        Pressure of each reading, (M,), Pa.
    """
    images, count = raw.shape
    deviations = np.empty(count)
    places = np.searchsorted(knots, pressures)
    for tactel in range(count):
        total, square = 0.0, 0.0
        for image in range(images):
            k = min(max(places[image], 1), len(knots) - 1)
            share = (pressures[image] - knots[k - 1]) / (knots[k] - knots[k - 1])
            share = min(max(share, 0.0), 1.0)
            value = expected[tactel, k - 1] + share * (
                expected[tactel, k] - expected[tactel, k - 1]
            )
            error = raw[image, tactel] - value
            total += error
            square += error * error
        deviations[tactel] = np.sqrt(max(square - total * total / images, 0.0) / (images - 1))
    return deviations


@njit(cache=True)
def fit_cubics(raws, pressures, curves):
    """Fit a monotone cubic through the knots of each tactel (Fritsch and Carlson 1980).

    Parameters
    ----------
    raws, pressures
        (N, K), non-decreasing. All pressures at the same reading are equally likely, so their mean
        counts.
    curves
        Output, (N, K, 3) float32, fields `RAW`, `PRESSURE` and `SLOPE`. If readings coincide, the
        last knots are equal. A tactel with a single reading has the pressure 0.
    """
    rows, count = raws.shape
    x, y, slope = np.empty(count), np.empty(count), np.empty(count)
    for row in range(rows):
        knots, first = 0, 0
        for k in range(1, count + 1):
            if k == count or raws[row, k] > raws[row, first]:
                x[knots], y[knots] = raws[row, first], np.mean(pressures[row, first:k])
                knots, first = knots + 1, k
        if knots < 2:
            y[0], slope[0] = 0.0, 0.0
        else:
            _slopes(x, y, knots, slope)
        for k in range(count):
            source = min(k, knots - 1)
            curves[row, k, RAW] = x[source]
            curves[row, k, PRESSURE] = max(y[source], 0.0)
            curves[row, k, SLOPE] = slope[source]


@njit(cache=True)
def _slopes(x, y, knots, slope):
    """Fill the slopes at the knots: weighted harmonic means, one-sided at the ends."""
    if knots == 2:
        slope[0] = slope[1] = (y[1] - y[0]) / (x[1] - x[0])
        return
    for k in range(1, knots - 1):
        before, after = x[k] - x[k - 1], x[k + 1] - x[k]
        left, right = (y[k] - y[k - 1]) / before, (y[k + 1] - y[k]) / after
        slope[k] = 0.0
        if left > 0.0 and right > 0.0:
            w1, w2 = 2.0 * after + before, after + 2.0 * before
            slope[k] = (w1 + w2) / (w1 / left + w2 / right)
    last = knots - 1
    slope[0] = _end_slope(x[1] - x[0], x[2] - x[1], y[1] - y[0], y[2] - y[1])
    slope[last] = _end_slope(
        x[last] - x[last - 1],
        x[last - 1] - x[last - 2],
        y[last] - y[last - 1],
        y[last - 1] - y[last - 2],
    )


@njit(cache=True)
def _end_slope(near, far, near_rise, far_rise):
    first, second = near_rise / near, far_rise / far
    slope = ((2.0 * near + far) * first - near * second) / (near + far)
    return min(max(slope, 0.0), 3.0 * first)


@njit(cache=True)
def curve_pressure(curves, tactel, reading):
    """Return the pressure of a tactel at a reading, Pa, >= 0.

    Beyond the outermost knots, it is their pressure.
    """
    last = curves.shape[1] - 1
    if reading <= curves[tactel, 0, RAW]:
        return curves[tactel, 0, PRESSURE]
    if reading >= curves[tactel, last, RAW]:
        return curves[tactel, last, PRESSURE]
    # Most tactels are near rest, so the search starts there with doubled steps.
    low, high = 0, 1
    while curves[tactel, high, RAW] <= reading:
        low, high = high, min(2 * high, last)
    while high - low > 1:
        middle = (low + high) >> 1
        if curves[tactel, middle, RAW] <= reading:
            low = middle
        else:
            high = middle
    width = float(curves[tactel, high, RAW] - curves[tactel, low, RAW])
    start, end = float(curves[tactel, low, PRESSURE]), float(curves[tactel, high, PRESSURE])
    left, right = width * curves[tactel, low, SLOPE], width * curves[tactel, high, SLOPE]
    t = (reading - curves[tactel, low, RAW]) / width
    rise = end - start
    return start + t * (
        left + t * (3.0 * rise - 2.0 * left - right + t * (left + right - 2.0 * rise))
    )


@njit(cache=True)
def curve_pressures(curves, readings, pressures):
    """Fill the pressures (N,), Pa, of readings (N,)."""
    for tactel in range(len(readings)):
        pressures[tactel] = curve_pressure(curves, tactel, float(readings[tactel]))

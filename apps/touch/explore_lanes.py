"""Where two pads shall go over an unknown object: lanes along both directions, half for each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

HALF_WIDTH, HALF_DEPTH, SHARE = 0.1, 0.07, 0.93
"""Half axes of what the pads may assume of the object's plan, m, and how far out their middles go:
a guess of its size, as a camera gives it."""
OUTERMOST, LANES = 0.085, 5
"""Each pad has its half of the object: lanes from the middle out to here along x, m, and number
of lanes in each of the two directions."""
QUICK_LANES = 2
"""Lanes of a first look."""
START = 0.3
"""Where a pad lands, as a share of the way out."""


def lanes(quick: bool) -> NDArray[np.float64]:
    """Corners of a pad's way over its half, (K, 2), m, outwards positive: along y, then along x."""
    count = QUICK_LANES if quick else LANES
    corners = [(START * OUTERMOST, 0.0)]
    for number, x in enumerate(np.linspace(0.0, OUTERMOST, count)):
        side = 1.0 if number % 2 else -1.0
        corners += [(x, side * HALF_DEPTH), (x, -side * HALF_DEPTH)]
    reach = SHARE * HALF_DEPTH
    for number, y in enumerate(np.linspace(-reach, reach, count + 2)[1:-1]):
        ends = (0.0, OUTERMOST) if number % 2 else (OUTERMOST, 0.0)
        corners += [(ends[0], y), (ends[1], y)]
    # Within the plan's ellipse already here, or the pad would wait where its lane is cut short.
    return np.array([_inside(np.array(corner)) for corner in corners])


def place_on_way(
    corners: NDArray[np.float64], way: NDArray[np.float64], gone: float, number: int
) -> NDArray[np.float64]:
    """Give where the left (0) or right (1) pad shall be, (2,), m: one mirrors the other.

    Parameters
    ----------
    corners, way
        Of the way (see :func:`lanes`), and their distances along it (see :func:`distances`).
    gone
        Of its length, m.
    number
        Which pad.
    """
    x, y = (np.interp(gone, way, corners[:, axis]) for axis in (0, 1))
    return _inside(np.array([x if number else -x, y]))


def distances(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give how far along the way each corner (K, 2) is, (K,), m."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])


def _inside(place: NDArray[np.float64]) -> NDArray[np.float64]:
    half = HALF_DEPTH * np.sqrt(max(SHARE**2 - (place[0] / HALF_WIDTH) ** 2, 0.0))
    return np.array([place[0], np.clip(place[1], -half, half)])

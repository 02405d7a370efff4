"""Plan lanes in both directions over an unknown object, one half for each of two pads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

HALF_WIDTH, HALF_DEPTH, SHARE = 0.1, 0.07, 0.93
"""Half axes of the ellipse assumed for the object's plan, m, and the fraction of it that the pad
centres cover. A camera can provide such an estimate of the size."""
OUTERMOST, LANES = 0.085, 5
"""Outermost lane of a pad's half along x, m, and number of lanes in each of the two directions."""
QUICK_LANES = 2
"""Number of lanes per direction of a quick scan."""
START = 0.3
"""Landing position of a pad, as a fraction of the outermost lane."""


def lanes(quick: bool) -> NDArray[np.float64]:
    """Return the corners (K, 2) of a pad's path over its half, m, first along y, then along x.

    Positive x points outwards from the object's centre.
    """
    count = QUICK_LANES if quick else LANES
    corners = [(START * OUTERMOST, 0.0)]
    for number, x in enumerate(np.linspace(0.0, OUTERMOST, count)):
        end = HALF_DEPTH if number % 2 else -HALF_DEPTH
        corners += [(x, end), (x, -end)]
    reach = SHARE * HALF_DEPTH
    for number, y in enumerate(np.linspace(-reach, reach, count + 2)[1:-1]):
        ends = (0.0, OUTERMOST) if number % 2 else (OUTERMOST, 0.0)
        corners += [(ends[0], y), (ends[1], y)]
    # The corners are limited to the ellipse here. Otherwise the pad would wait on shortened lanes.
    return np.array([_inside(np.array(corner)) for corner in corners])


def position_on_path(
    corners: NDArray[np.float64], path_distances: NDArray[np.float64], travelled: float, number: int
) -> NDArray[np.float64]:
    """Compute the goal position (2,) of the left (0) or right (1) pad, m. The paths are mirrored.

    Parameters
    ----------
    corners, path_distances
        Corners of the path (see :func:`lanes`) and their distances along it (:func:`distances`).
    travelled
        Travelled distance along the path, m.
    number
        Index of the pad.
    """
    x, y = (np.interp(travelled, path_distances, corners[:, axis]) for axis in (0, 1))
    return _inside(np.array([x if number else -x, y]))


def distances(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the distance (K,) of each corner (K, 2) along the path, m."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])


def _inside(place: NDArray[np.float64]) -> NDArray[np.float64]:
    half = HALF_DEPTH * np.sqrt(max(SHARE**2 - (place[0] / HALF_WIDTH) ** 2, 0.0))
    return np.array([place[0], np.clip(place[1], -half, half)])

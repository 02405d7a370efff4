"""Grasps that are one: close ones, and those that differ by a turn about an axis of symmetry."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .candidates import ROUND_EXPONENT
from .surface_model import ObjectSurface

SAME_DISTANCE, SAME_ANGLE_COSINE = 0.012, float(np.cos(np.radians(25.0)))
"""Two grasps that differ by less are one: distance in m, and cosine of the angle."""
MIN_RATIO = 0.9
"""Minimum ratio of the semi-axes of a section that counts as round."""
SAME_POSITION = 0.008
"""Two grasps may differ by as much along the axis and across it, m."""
SAME_COSINE = 0.17
"""Two grasps may differ by as much in the cosines to the axis: 10° near a right angle."""


def symmetry_axes(surface: ObjectSurface) -> NDArray[np.float64]:
    """Return the axes of symmetry of an object of one solid, (k, 2, 3): point, m, and direction.

    An object of several solids has none.
    """
    axes = []
    if len(surface.solids) == 1:
        solid = surface.solids[0]
        e1, e2 = solid.exponents
        a = solid.semi_axes
        for first, second, exponent in ((0, 1, e2), (1, 2, e1), (2, 0, e1)):
            ratio = min(a[first], a[second]) / max(a[first], a[second])
            if exponent >= ROUND_EXPONENT and ratio >= MIN_RATIO:
                axes.append((solid.centre, solid.rotation[:, 3 - first - second]))
    return np.array(axes, dtype=np.float64).reshape(-1, 2, 3)


@njit(cache=True, nogil=True)
def distinct(tips, rotations, total, axes, count, least):
    """Return the indices of the best grasps of an object that differ, best first, (k,).

    Parameters
    ----------
    tips, rotations
        Poses, (n, 3), m, and (n, 3, 3).
    total
        Their probabilities, (n,).
    axes
        Axes of symmetry from :func:`symmetry_axes`.
    count
        Maximum number of grasps.
    least
        Minimum probability.
    """
    left = total >= least
    chosen = np.empty(count, np.int64)
    found = 0
    while found < count:
        best = -1
        for k in range(len(total)):
            if left[k] and (best < 0 or total[k] > total[best]):
                best = k
        if best < 0:
            break
        chosen[found] = best
        found += 1
        left[best] = False
        for k in range(len(total)):
            if left[k] and _is_same(tips[k], rotations[k], tips[best], rotations[best], axes):
                left[k] = False
    return chosen[:found]


@njit(cache=True, nogil=True)
def repeats(tips, rotations, total, others, axes):
    """Return a mask (n,) of the poses that equal a better grasp of `others`.

    `others` holds positions, rotations and probabilities.
    """
    places, turns, values = others
    out = np.zeros(len(total), np.bool_)
    for k in range(len(total)):
        for other in range(len(values)):
            if total[k] <= values[other] and not out[k]:
                out[k] = _is_same(tips[k], rotations[k], places[other], turns[other], axes)
    return out


@njit(cache=True, nogil=True)
def _is_same(tip, rotation, other, turned, axes):
    """Return whether two poses are close, or differ by a turn about one of the axes alone."""
    if (
        np.sqrt(np.sum((tip - other) ** 2)) <= SAME_DISTANCE
        and abs(np.sum(rotation[:, 0] * turned[:, 0])) > SAME_ANGLE_COSINE
        and np.sum(rotation[:, 2] * turned[:, 2]) > SAME_ANGLE_COSINE
    ):
        return True
    for axis in axes:
        along, across = _place(axis, tip)
        level, apart = _place(axis, other)
        if abs(along - level) >= SAME_POSITION or abs(across - apart) >= SAME_POSITION:
            continue
        approach = np.sum((rotation[:, 2] - turned[:, 2]) * axis[1])
        closing = abs(np.sum(rotation[:, 0] * axis[1])) - abs(np.sum(turned[:, 0] * axis[1]))
        if abs(approach) < SAME_COSINE and abs(closing) < SAME_COSINE:
            return True
    return False


@njit(cache=True, nogil=True)
def _place(axis, tip):
    """Return the coordinate of a point along an axis and its distance from it, m."""
    offset = tip - axis[0]
    along = np.sum(offset * axis[1])
    return along, np.sqrt(np.sum((offset - along * axis[1]) ** 2))

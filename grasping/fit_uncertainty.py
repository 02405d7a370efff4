"""Uncertainty of a fitted solid in the directions that matter for a grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SuperquadricFit

MAX_STD = 0.010
"""Maximum standard deviation that is returned, m. A hand that opens wider finds no object between
its fingers."""


def width_stds(fit: SuperquadricFit, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the standard deviations of the width along unit directions (K, 3), (K,), m.

    They are 0 if they are unknown.
    """
    widths = fit.widths(directions)
    if not widths:
        return np.zeros(len(directions))
    return np.minimum([width.sigma for width in widths], MAX_STD)


def max_side_std(fit: SuperquadricFit) -> float:
    """Return the maximum standard deviation of an object's six sides, m, at most `MAX_STD`."""
    return min(max((side.sigma for side in fit.sides), default=0.0), MAX_STD)

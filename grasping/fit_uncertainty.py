"""Uncertainty of a fitted solid in the directions that matter for a grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from eyehand.perception import SuperquadricFit

MAX_STD = 0.010
"""Maximum standard deviation that is returned, m. A hand that opens wider finds no object between
its fingers."""


def width_std(fit: SuperquadricFit, direction: NDArray[np.float64]) -> float:
    """Return the standard deviation of the width along a unit direction (3,), m; 0 if unknown."""
    width = fit.width(direction)
    return 0.0 if width is None else min(width.sigma, MAX_STD)


def max_side_std(fit: SuperquadricFit) -> float:
    """Return the maximum standard deviation of an object's six sides, m, at most `MAX_STD`."""
    return min(max((side.sigma for side in fit.sides), default=0.0), MAX_STD)

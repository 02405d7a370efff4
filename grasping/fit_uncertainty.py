"""Uncertainty of a fitted solid in the directions that matter for a grasp."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SuperquadricFit

MAX_STD = 0.010
"""Maximum standard deviation that is returned, m. The first-order estimate of an unseen side is
unbounded, but the table, free space and the other sides still bound the object."""
MIN_UNSEEN_STD = 0.004
"""Minimum standard deviation of an unseen side, m."""
_CENTRE = slice(8, 11)


def width_std(fit: SuperquadricFit, direction: NDArray[np.float64]) -> float:
    """Return the standard deviation of the width along a unit direction (3,), m; 0 if unknown.

    The solid's support along d is at most c·d + Σ a_k |d·e_k|, which is linear in centre and
    semi-axes. The centre cancels in the sum of two opposite sides.
    """
    solid, uncertainty = fit.superquadric, fit.uncertainty
    if solid is None or uncertainty is None:
        return 0.0
    weights = np.abs(direction @ solid.rotation)
    variance = 4.0 * float(weights @ uncertainty.covariance[:3, :3] @ weights)
    facing = "xyz"[int(np.argmax(weights))]
    unseen = any(side[1] == facing for side in uncertainty.unobserved)
    lower = MIN_UNSEEN_STD if unseen else 0.0
    return float(np.clip(np.sqrt(max(variance, 0.0)), lower, MAX_STD))


def max_side_std(fit: SuperquadricFit) -> float:
    """Return the maximum standard deviation of a solid's six sides, m, at most `MAX_STD`."""
    solid, uncertainty = fit.superquadric, fit.uncertainty
    if solid is None or uncertainty is None:
        return 0.0
    slopes = np.zeros((6, len(uncertainty.covariance)))
    slopes[:, :3] = np.vstack([np.eye(3), np.eye(3)])
    slopes[:3, _CENTRE] = solid.rotation.T
    slopes[3:, _CENTRE] = -solid.rotation.T
    variance = np.einsum("si,ij,sj->s", slopes, uncertainty.covariance, slopes).max()
    return float(min(np.sqrt(max(float(variance), 0.0)), MAX_STD))

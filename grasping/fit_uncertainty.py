"""How far a fit may be wrong about where an object ends, in a direction that a hand asks about."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from eyehand.perception import SuperquadricFit

MOST_DOUBT = 0.010
"""Largest standard deviation that counts, m: of a side that nobody saw the first-order figure has
no bound, while the table, free space and the other sides still bound the object."""
UNSEEN_DOUBT = 0.004
"""Least standard deviation of a side that nobody saw, m."""
_CENTRE = slice(8, 11)


def doubt_along(fit: SuperquadricFit, direction: NDArray[np.float64]) -> float:
    """Standard deviation of the caliper width along a unit direction (3,), m; 0 if not known.

    The solid's support along d is c·d + Σ a_k |d·e_k| at most, linear in centre and semi-axes; the
    centre drops out of the sum of two opposite sides.
    """
    solid, doubt = fit.superquadric, fit.uncertainty
    if solid is None or doubt is None:
        return 0.0
    shares = np.abs(direction @ solid.rotation)
    variance = 4.0 * float(shares @ doubt.covariance[:3, :3] @ shares)
    # One of the two sides across the direction, of those that nobody saw.
    facing = "xyz"[int(np.argmax(shares))]
    least = UNSEEN_DOUBT if any(side[1] == facing for side in doubt.unobserved) else 0.0
    return float(np.clip(np.sqrt(max(variance, 0.0)), least, MOST_DOUBT))


def side_doubt(fit: SuperquadricFit) -> float:
    """Standard deviation of the least sure side of a fitted solid, m, no more than counts."""
    solid, doubt = fit.superquadric, fit.uncertainty
    if solid is None or doubt is None:
        return 0.0
    slopes = np.zeros((6, len(doubt.covariance)))
    slopes[:, :3] = np.vstack([np.eye(3), np.eye(3)])
    slopes[:3, _CENTRE] = solid.rotation.T
    slopes[3:, _CENTRE] = -solid.rotation.T
    variance = np.einsum("si,ij,sj->s", slopes, doubt.covariance, slopes).max()
    return float(min(np.sqrt(max(float(variance), 0.0)), MOST_DOUBT))

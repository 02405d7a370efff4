"""The long axis of a contact from its second moments."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True)
def long_axis(x, y, weights, count):
    """Compute the angle of the long axis, and how elongated the contact is.

    The angle is half that of the doubled-angle vector (Σ w (x² - y²), Σ 2 w x y). So 0 and π are
    the same direction, and the angle does not jump inside its range.

    Parameters
    ----------
    x, y
        (>= count,) each, positions in the plane, m, from any origin.
    weights
        (>= count,), >= 0, forces, N.
    count
        Number of positions.

    Returns
    -------
    Angle in (-π/2, π/2] rad, and confidence (λ1-λ2)/(λ1+λ2) of the eigenvalues of the second
    moments: 0 is round, 1 is a line. Both are 0 if all positions are equal.
    """
    total, mean_x, mean_y = 0.0, 0.0, 0.0
    for k in range(count):
        total += weights[k]
        mean_x += weights[k] * x[k]
        mean_y += weights[k] * y[k]
    if not total > 0.0:
        return 0.0, 0.0
    mean_x /= total
    mean_y /= total
    cosine, sine, spread = 0.0, 0.0, 0.0
    for k in range(count):
        dx, dy = x[k] - mean_x, y[k] - mean_y
        cosine += weights[k] * (dx * dx - dy * dy)
        sine += weights[k] * 2.0 * dx * dy
        spread += weights[k] * (dx * dx + dy * dy)
    length = math.hypot(cosine, sine)
    if not spread > 0.0 or length == 0.0:
        return 0.0, 0.0
    angle = 0.5 * math.atan2(sine, cosine)
    angle = 0.5 * math.pi if angle <= -0.5 * math.pi else angle
    return angle, min(length / spread, 1.0)

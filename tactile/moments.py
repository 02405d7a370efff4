"""The long axis of a contact from its second moments."""

from __future__ import annotations

import math

from numba import njit


@njit(cache=True)
def long_axis(x, y, weights, count):
    """Angle of the long axis, and how much longer than wide the contact is.

    The angle is half of that of the doubled-angle vector (Σ w (x² - y²), Σ 2 w x y), so 0 and π
    are the same direction and nothing jumps inside the range.

    Parameters
    ----------
    x, y
        (>= count,) each, positions in the plane, m; their origin does not matter.
    weights
        (>= count,), >= 0: forces, N.
    count
        How many of them count.

    Returns
    -------
    Angle in (-π/2, π/2] rad, and confidence (λ1-λ2)/(λ1+λ2) of the second moments' eigenvalues,
    0 round to 1 a line; both 0 where all lies in one point.
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
    split = math.hypot(cosine, sine)
    if not spread > 0.0 or split == 0.0:
        return 0.0, 0.0
    return half_angle(cosine, sine), min(split / spread, 1.0)


@njit(cache=True)
def half_angle(cosine, sine):
    """Half of the angle of (cosine, sine), rad in (-π/2, π/2]."""
    angle = 0.5 * math.atan2(sine, cosine)
    return 0.5 * math.pi if angle <= -0.5 * math.pi else angle

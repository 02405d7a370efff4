"""Compiled probability that a grasp resists the wrenches of lift and carry.

The model is that of hard friction with soft patches: each contact carries a force in its friction
cone, and the contacts of a side together carry tangential force and torsion up to an ellipsoidal
limit surface (Howe and Cutkosky, Practical force-motion models for sliding manipulation, 1996).
Errors of the fit, friction, mass and centre of mass are sampled from fixed normal variates.
"""

from __future__ import annotations

import numpy as np
from numba import njit

VARIATES = 9
"""Normal variates of a sample: two ends of the row, depth, finger slope, thumb slope, friction,
logarithm of the mass, and the two coordinates of the centre of mass."""


@njit(cache=True, nogil=True, error_model="numpy")
def hold_probability(variates, rows, slopes, ends, errors, load, hand, friction):
    """Return the share of samples in which the grasp holds.

    Parameters
    ----------
    variates
        Standard normal variates, (S, `VARIATES`).
    rows
        Position of each finger along the row, (R,), m. Fingers that do not pull are left out.
    slopes
        Slope of the surface towards the palm's direction at the fingers and at the thumb, (2,). It
        is positive where the object becomes thinner towards the fingertips.
    ends
        Low and high end of the object along the row, depth of the tips beyond the near face, and
        the minimum of that depth, (4,), m.
    errors
        Standard deviations: ends of the row, m; depth, m; slopes; logarithm of the mass; centre of
        mass along the row and across row and closing direction, m; friction, (7,).
    load
        Weight and inertia of the likely mass, N; shares of this force along closing direction, row
        and palm; offset of the centre of mass from the contacts along row and palm, m, (6,).
    hand
        Force of one finger, N; half width of a finger's pad and of the thumb's, m; minimum overlap,
        m; radius of a contact patch, m; number of fingers that must touch, (6,).
    friction
        Likely coefficient of friction.
    """
    held = 0
    for s in range(len(variates)):
        v = variates[s]
        low, high = ends[0] + errors[0] * v[0], ends[1] + errors[0] * v[1]
        if ends[2] + errors[1] * v[2] < ends[3]:
            continue
        touching, total, squares = 0, 0.0, 0.0
        for k in range(len(rows)):
            left, right = max(low, rows[k] - hand[1]), min(high, rows[k] + hand[1])
            if right - left >= hand[3]:
                place = 0.5 * (left + right)
                touching += 1
                total += place
                squares += place * place
        left, right = max(low, -hand[2]), min(high, hand[2])
        if touching < hand[5] or right - left < hand[3]:
            continue
        mu = max(friction + errors[6] * v[5], 0.05)
        # An object that becomes thicker towards the tips is squeezed out of the hand. The opposite
        # slope presses it towards the palm.
        if min(slopes[0] + errors[2] * v[3], slopes[1] + errors[2] * v[4]) < -mu:
            continue
        mean = total / touching
        # The thumb opposes the resultant of the fingers anywhere on its pad. Beyond it, the object
        # turns until it does, or leaves the hand.
        lever = max(mean - right, left - mean, 0.0)
        normal = touching * hand[0]
        spread = np.sqrt(max(squares / touching - mean * mean, 0.0) + hand[4] * hand[4])
        if lever > spread + mu * hand[4]:
            continue
        force = load[0] * np.exp(errors[3] * v[6])
        # Both sides carry; the part along the closing direction is carried by the normal forces.
        across = force * np.sqrt(load[2] * load[2] + load[3] * load[3])
        along = force * abs(load[1])
        row, palm = load[4] - mean + errors[4] * v[7], load[5] + errors[5] * v[8]
        torque = force * abs(row * load[3] - palm * load[2])
        capacity = 2.0 * mu * normal
        share = across / capacity
        twist = torque / (capacity * spread)
        if share * share + twist * twist < 1.0 and along < normal:
            held += 1
    return held / len(variates)

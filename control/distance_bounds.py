"""The compiled bounds on a command by the distances in this posture and at standstill.

The certificate of a command is that the arm can brake after it and then stands with all distances
at least the margin. Each cycle measures the distances at the standstill of the brake, and bounds
how far the command may move this standstill towards an obstacle. The brake's own command moves it
nowhere, so it satisfies every bound (see :mod:`braking_kernels` for joint limits). The distances in
the present posture are bounded too, because the way to standstill is curved: without these bounds,
reaches beside boxes cut corners by up to 0.3 mm. Where the way is long, postures on it are measured
as well: an arm at 2 rad/s needs 0.3 rad to brake, and may end clear beyond an edge that it touches.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .braking_kernels import ACCELERATION, Brake
from .packed_options import DAMPER, DT, MARGIN
from .proximity_kernels import distance_row
from .safety_kernels import SLACK, min_distance_rate

APPROACHING = 0.01
"""Minimum speed of an obstacle towards the arm that counts as an approach, m/s."""
EVASION_SHARE = 0.5
"""Share of the acceleration limits that evades an obstacle. The rest is left for jerk limits, other
bounds, and obstacles that turn."""
MIN_EVASION = 1.5
"""Minimum acceleration away from an obstacle that is counted on, m/s². Near the base the arm has
less. It then reports an approach at 0.5 m/s from 80 mm on."""


class Chain(NamedTuple):
    """The inputs of the rows of distances, see :class:`ProximityTables` and `near_pairs`."""

    pairs: NDArray[np.int64]
    anchors: NDArray[np.float64]
    axes: NDArray[np.float64]
    joints: NDArray[np.int64]
    moves: NDArray[np.bool_]
    twists: NDArray[np.float64]


class BrakingCase(NamedTuple):
    """A posture, the last command in it, and how the arm can brake."""

    q: NDArray[np.float64]
    """(n,)."""
    motion: NDArray[np.float64]
    """(2, n): velocity of the last command, and its acceleration."""
    limits: NDArray[np.float64]
    """(n, 5), see :mod:`braking_kernels`."""
    low: NDArray[np.float64]
    """Smallest velocity (n,) that the joint bounds allow."""
    high: NDArray[np.float64]
    """Largest one (n,)."""
    braking: Brake
    """The brake after the last command."""
    options: NDArray[np.float64]
    """See :mod:`packed_options`."""


class DistanceBounds(NamedTuple):
    """Bounds rows @ command >= min_rates, or at least least_rates. R rows."""

    rows: NDArray[np.float64]
    """(R, n)."""
    min_rates: NDArray[np.float64]
    """(R,), m/s, with recovery of pairs inside the margin."""
    least_rates: NDArray[np.float64]
    """(R,), m/s, without recovery. The brake satisfies them if no obstacle moves."""
    pairs: NDArray[np.int64]
    """(R,): the pair of each row."""


@njit(cache=True)
def distance_rows(near, chain, rows, drifts):
    """Fill derivatives (P, n) and drifts (P,) of the distances of `measure_near`."""
    for row in range(len(near)):
        drifts[row] = distance_row(
            near[row], chain.pairs[int(near[row, 0])], chain.anchors, chain.axes, chain.joints,
            chain.moves, chain.twists, rows[row],
        )  # fmt: skip


@njit(cache=True)
def limit_approach(distance, rows, drifts, limits, options):
    """Change the drifts (P,) of approaching obstacles so that the arm evades them in time.

    An arm that gains speed at the rate a needs the distance c² / (2 a) until it is as fast as an
    obstacle that closes in at c. So c² <= 2 a left must hold, with what is left to the margin. The
    drift is raised to the one at which the velocity damper demands this. ``limits`` are (n, 5).
    """
    damping = options[DAMPER] / options[DT]
    for row in range(len(distance)):
        if drifts[row] > -APPROACHING:
            continue
        left = distance[row] - options[MARGIN]
        acceleration = 0.0
        for joint in range(len(limits)):
            if rows[row, joint] != 0.0:
                acceleration += abs(rows[row, joint]) * limits[joint, ACCELERATION]
        usable = max(EVASION_SHARE * acceleration, MIN_EVASION)
        if left > 0.0 and usable < np.inf:
            drifts[row] -= max(damping * left - np.sqrt(2.0 * usable * left), 0.0)


@njit(cache=True)
def bounds_now(near, rows, drifts, case, bounds, used):
    """Add the bounds by the distances in this posture; return the number of rows in use.

    The rate is that of the velocity damper. Where the arm cannot keep it, the rate of the brake is
    sufficient. A second bound keeps the standstill on this side of the plane through the margin
    that is normal to the distance now: a fast arm could otherwise stop clear of an obstacle beyond
    its corner, after it has touched the corner on the way.
    """
    q, low, high, braking, options = case.q, case.low, case.high, case.braking, case.options
    damping = options[DAMPER] / options[DT]
    for row in range(len(near)):
        left, braked = near[row, 1] - options[MARGIN], 0.0
        for joint in range(len(low)):
            left += rows[row, joint] * (braking.stop[joint] - q[joint])
            scaled = rows[row, joint] * braking.advance[joint] / options[DT]
            bounds.rows[used, joint] = scaled
            braked += scaled * braking.command[joint]
        rate = braked - damping * max(left, 0.0)
        if _can_break(bounds.rows[used], rate, low, high):
            bounds.min_rates[used] = bounds.least_rates[used] = rate
            bounds.pairs[used] = int(near[row, 0])
            used += 1
        braked = 0.0
        for joint in range(len(low)):
            braked += rows[row, joint] * braking.command[joint]
        rate = min_distance_rate(near[row, 1], drifts[row], options, True)
        if _can_break(rows[row], rate, low, high):
            bounds.rows[used] = rows[row]
            bounds.min_rates[used] = rate
            bounds.least_rates[used] = min(rate, braked)
            bounds.pairs[used] = int(near[row, 0])
            used += 1
    return used


@njit(cache=True)
def bounds_at_stop(near, rows, drifts, until, case, bounds, used):
    """Add the bounds by the distances on the way to standstill; return the number of rows in use.

    The command v' moves the standstill of joint j by advance_j (v'_j - b_j), with the brake's
    command b, and a posture on the way by the time until then. So a distance d changes by
    row · (advance (v' - b)). One cycle may use up a fraction of what is left to the margin.
    ``until`` is the time after which the arm is there, infinite for standstill, s.
    """
    low, high, braking, options = case.low, case.high, case.braking, case.options
    for row in range(len(near)):
        braked = 0.0
        for joint in range(len(low)):
            scaled = rows[row, joint] * min(braking.advance[joint], until) / options[DT]
            bounds.rows[used, joint] = scaled
            braked += scaled * braking.command[joint]
        rate = braked + min_distance_rate(near[row, 1], drifts[row], options, True)
        if _can_break(bounds.rows[used], rate, low, high):
            bounds.min_rates[used] = rate
            bounds.least_rates[used] = braked + min_distance_rate(
                near[row, 1], drifts[row], options, False
            )
            bounds.pairs[used] = int(near[row, 0])
            used += 1
    return used


@njit(cache=True)
def _can_break(row, min_rate, low, high):
    """Return whether a command within the joint bounds can violate a row."""
    least = 0.0
    for joint in range(len(row)):
        least += row[joint] * (low[joint] if row[joint] > 0.0 else high[joint])
    return not least >= min_rate + SLACK

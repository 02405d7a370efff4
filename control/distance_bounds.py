"""The compiled bounds on a command by the distances in this posture and at standstill.

The certificate of a command is that the arm can brake after it and then stands with all distances
at least the margin. Each cycle measures the distances at the standstill of the brake, and bounds
how far the command may move this standstill towards an obstacle. The brake's own command moves it
nowhere, so it satisfies every bound (see :mod:`braking_kernels` for joint limits). The distances in
the present posture are bounded too, because the way to standstill is curved: without these bounds,
reaches beside boxes cut corners by up to 0.3 mm.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit

from .braking_kernels import ACCELERATION
from .packed_options import DAMPER, DT, MARGIN
from .proximity_kernels import distance_row
from .safety_kernels import SLACK, min_distance_rate

if TYPE_CHECKING:
    from numpy.typing import NDArray

BEYOND_FRAME = 0.2
"""Distance up to which the hand and a held object extend beyond the controlled frame, m."""
APPROACHING = 0.01
"""Minimum speed of an obstacle towards the arm that counts as an approach, m/s."""
EVASION_SHARE = 0.5
"""Share of the acceleration limits that evades an obstacle. The rest is left for jerk limits, other
bounds, and obstacles that turn."""
MIN_EVASION = 1.5
"""Minimum acceleration away from an obstacle that is counted on, m/s². Near the base the arm has
less. It then reports an approach at 0.5 m/s from 80 mm on."""
MOVING = 1e-9
"""Minimum distance between the present posture and standstill, rad or m. Below it both count as
one posture."""


class Chain(NamedTuple):
    """What the rows of distances need, see :class:`ProximityTables` and `near_pairs`."""

    pairs: NDArray[np.int64]
    anchors: NDArray[np.float64]
    axes: NDArray[np.float64]
    joints: NDArray[np.int64]
    moves: NDArray[np.bool_]
    twists: NDArray[np.float64]


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
    drift is raised to the one at which the velocity damper demands this. Return whether an obstacle
    approaches. ``limits`` are (n, 5).
    """
    damping = options[DAMPER] / options[DT]
    approached = False
    for row in range(len(distance)):
        if drifts[row] > -APPROACHING:
            continue
        approached = True
        left = distance[row] - options[MARGIN]
        acceleration = 0.0
        for joint in range(len(limits)):
            if rows[row, joint] != 0.0:
                acceleration += abs(rows[row, joint]) * limits[joint, ACCELERATION]
        usable = max(EVASION_SHARE * acceleration, MIN_EVASION)
        if left > 0.0 and usable < np.inf:
            drifts[row] -= max(damping * left - np.sqrt(2.0 * usable * left), 0.0)
    return approached


@njit(cache=True)
def is_moving(q, stop):
    """Return whether the arm moves: its standstill differs from its posture."""
    farthest = 0.0
    for joint in range(len(q)):
        farthest = max(farthest, abs(stop[joint] - q[joint]))
    return farthest > MOVING


@njit(cache=True)
def relevant_distance(jacobian, joints, low, high, braking, options):
    """Return the distance at standstill beyond which no pair bounds the command, m.

    Within the joint bounds (n,), a command moves the standstill of the hand by at most the sum over
    the joints. ``jacobian`` (6, n) is that of the controlled frame.
    """
    change = 0.0
    for joint in range(len(low)):
        lever = 0.0
        for axis in range(3):
            lever += jacobian[axis, joint] ** 2
        reach = np.sqrt(lever) + (BEYOND_FRAME if joints[joint, 2] == 1 else 0.0)
        b = braking.command[joint]
        farther = max(high[joint] - b, b - low[joint])
        change += reach * braking.advance[joint] * farther
    return options[MARGIN] + change / options[DAMPER]


@njit(cache=True)
def bounds_now(near, rows, drifts, low, high, braking, options, bounds, used):
    """Add the bounds by the distances in this posture; return the number of rows in use.

    The rate is that of the velocity damper. Where the arm cannot keep it, the rate of the brake is
    sufficient.
    """
    for row in range(len(near)):
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
def bounds_at_stop(near, rows, drifts, low, high, braking, options, bounds, used):
    """Add the bounds by the distances at standstill; return the number of rows in use.

    The command v' moves the standstill of joint j by advance_j (v'_j - b_j), with the brake's
    command b. So a distance d changes by row · (advance (v' - b)). One cycle may use up a fraction
    of what is left to the margin.
    """
    for row in range(len(near)):
        braked = 0.0
        for joint in range(len(low)):
            scaled = rows[row, joint] * braking.advance[joint] / options[DT]
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

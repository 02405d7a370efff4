"""Braking within the acceleration and jerk limits of every joint, in compiled kernels.

A robot holds each commanded velocity for one cycle. In a cycle, a joint at velocity v changes it by
dt a'. The limits are |a'| <= A and |a' - a| <= c, with the last acceleration a and c = J dt.

**The brake.** :func:`brake` returns the a' that leads to standstill. Let s(a) be the sum of
a - c, a - 2c, ... down to zero (for negative a, mirrored): what the velocity still changes, divided
by dt, while the acceleration fades to zero as fast as it may. Then e = v / dt + s(a) is the
velocity that remains after fading. The brake chooses the a' for which the next e is zero, or the
nearest a' within the limits. Because fading itself keeps e, the brake never moves e away from zero
or across it, and every cycle that does not reach e = 0 moves e by at least c or by A. So the joint
stands still after finitely many cycles.

**Recursive feasibility.** Let S(v', a') be the farthest position that the brake reaches after the
command v'. Each cycle accepts the commands v' with S(v', a') <= limit and |e'| <= V. If v' was
accepted, the next cycle accepts the brake's command b: the brake from (v', a') starts with b, so
its farthest position is that of the remaining motion, S(b) <= S(v', a') <= limit, and |e| does not
grow. So there is always an accepted command, and it keeps every limit (:func:`joint_bounds`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .packed_options import DAMPER, DT, LIMIT_MARGIN

LOWER, UPPER, SPEED, ACCELERATION, JERK = range(5)
"""Columns of the joint limits (n, 5)."""
STILL = 1e-12
"""Velocity below which a joint stands still, rad/s or m/s."""
MAX_CYCLES = 100_000
"""Maximum number of cycles of a simulated brake. Cycles at full deceleration count as one."""
HALVINGS = 14
"""Number of bisections of a velocity interval. The accepted end is always a valid command."""


class Brake(NamedTuple):
    """The braking of each joint in one cycle. Arrays (n,)."""

    command: NDArray[np.float64]
    """Velocity that the brake commands now, rad/s or m/s."""
    stop: NDArray[np.float64]
    """Joint positions at standstill if the joint brakes now, rad or m."""
    advance: NDArray[np.float64]
    """Change of the position at standstill per change of the command, s."""


@njit(cache=True)
def fading(acceleration, change):
    """Return s(a): what the velocity changes, divided by dt, until the acceleration is zero."""
    size = abs(acceleration)
    if size <= change:
        return 0.0
    count = math.floor(size / change)
    total = count * size - change * count * (count + 1) / 2
    return math.copysign(total, acceleration)


@njit(cache=True)
def acceleration_for(total, change):
    """Return the a' with a' + s(a') = total."""
    size = abs(total)
    if size <= change:
        return total
    count = math.floor(0.5 * (math.sqrt(1.0 + 8.0 * size / change) - 1.0))
    return math.copysign((size + change * count * (count + 1) / 2) / (count + 1), total)


@njit(cache=True)
def brake(velocity, acceleration, limit, change, dt):
    """Return the acceleration (of this cycle) that leads to standstill; see the module."""
    wanted = acceleration_for(-velocity / dt, change)
    low, high = max(-limit, acceleration - change), min(limit, acceleration + change)
    return min(max(wanted, low), high)


@njit(cache=True)
def brake_command(motion, limits, dt):
    """Return the velocity (n,) that the brake commands after the last command, rad/s.

    ``motion`` (2, n) is the velocity of the last command, and its acceleration.
    """
    command = np.empty(len(limits))
    for joint in range(len(limits)):
        v, a = motion[0, joint], motion[1, joint]
        change = limits[joint, JERK] * dt
        now = brake(v, a, limits[joint, ACCELERATION], change, dt)
        command[joint] = v + dt * now
        if abs(command[joint]) <= STILL:
            command[joint] = 0.0
    return command


@njit(cache=True)
def brake_cycles(command, limits, dt):
    """Return about how many cycles the brake takes from its first command (n,) on."""
    longest = 0.0
    for joint in range(len(limits)):
        longest = max(longest, abs(command[joint]) / (limits[joint, ACCELERATION] * dt))
    return 1 + math.ceil(longest)


@njit(cache=True)
def braked_posture(q, motion, limits, dt, cycles, posture):
    """Fill the posture (n,) after some cycles of the brake from the last command on."""
    for joint in range(len(limits)):
        v, a = motion[0, joint], motion[1, joint]
        limit, change = limits[joint, ACCELERATION], limits[joint, JERK] * dt
        posture[joint] = q[joint]
        for _ in range(cycles):
            a = brake(v, a, limit, change, dt)
            v += dt * a
            posture[joint] += dt * v


@njit(cache=True)
def braking_distance(velocity, acceleration, limit, change, dt):
    """Simulate the brake after a command; return the displacements at its end, lowest and highest.

    Parameters
    ----------
    velocity, acceleration
        The velocity of the last command and its acceleration.
    limit, change
        A, and the maximum change of the acceleration per cycle.
    dt
        Control period, s.
    """
    position = lowest = highest = 0.0
    # Above this velocity, divided by dt, the brake stays at its full deceleration.
    full = np.inf if math.isinf(limit) else limit + fading(limit, change)
    for _ in range(MAX_CYCLES):
        if abs(velocity) <= STILL and abs(acceleration) <= change:
            break
        acceleration = brake(velocity, acceleration, limit, change, dt)
        velocity += dt * acceleration
        position += dt * velocity
        left = abs(velocity) / dt
        if abs(acceleration) == limit and velocity * acceleration < 0.0 and left >= full:
            count = math.floor((left - full) / limit) + 1
            position += dt * (count * velocity + dt * acceleration * count * (count + 1) / 2)
            velocity += count * dt * acceleration
        lowest, highest = min(lowest, position), max(highest, position)
    return position, lowest, highest


@njit(cache=True)
def joint_bounds(q, motion, limits, options, recover, low, high, braking):
    """Fill the minimum and maximum next velocities (n,), and the brake's command and its end.

    Besides the limits of speed, acceleration and jerk, the position at standstill may come nearer
    to a joint limit by a fraction of what is left to it (the option `damper`). The brake's command
    lies between the bounds.

    Parameters
    ----------
    q
        Joint positions (n,).
    motion
        (2, n): velocity of the last command, and its acceleration.
    limits
        (n, 5): lower, upper, speed, acceleration, jerk. The last two may be infinite.
    options
        See :mod:`packed_options`.
    recover
        Whether a joint outside its range must return. Otherwise it must only not go farther.
    low, high
        (n,) each, to be filled.
    braking
        A :class:`Brake`, whose `command` and `stop` are filled.
    """
    dt, fraction = options[DT], options[DAMPER]
    for joint in range(len(q)):
        speed, limit = limits[joint, SPEED], limits[joint, ACCELERATION]
        change = limits[joint, JERK] * dt
        v, a = motion[0, joint], motion[1, joint]
        now = brake(v, a, limit, change, dt)
        b = v + dt * now
        end, _, _ = braking_distance(b, now, limit, change, dt)
        braking.command[joint], braking.stop[joint] = b, q[joint] + dt * b + end
        highest = min(min(limit, a + change), acceleration_for((speed - v) / dt, change))
        lowest = max(max(-limit, a - change), -acceleration_for((speed + v) / dt, change))
        top, bottom = max(v + dt * highest, b), min(v + dt * lowest, b)
        below = q[joint] - (limits[joint, LOWER] + options[LIMIT_MARGIN])
        above = (limits[joint, UPPER] - options[LIMIT_MARGIN]) - q[joint]
        if below + above < 0.0:
            # The range is narrower than the two margins: the joint may only go to its middle.
            to_middle = 0.5 * fraction / dt * (above - below)
            low[joint] = high[joint] = min(max(to_middle, bottom), top) if recover else b
            continue
        high[joint] = _stopping((v, limit, change, dt), b, top, above, fraction)
        low[joint] = -_stopping((-v, limit, change, dt), -b, -bottom, below, fraction)
        if recover and above < 0.0:
            high[joint] = max(min(high[joint], fraction / dt * above), bottom)
            low[joint] = min(low[joint], high[joint])
        elif recover and below < 0.0:
            low[joint] = min(max(low[joint], -fraction / dt * below), top)
            high[joint] = max(low[joint], high[joint])


@njit(cache=True)
def _farthest(joint_state, command):
    """Return the farthest displacement in positive direction after a command."""
    v, limit, change, dt = joint_state
    after = (command - v) / dt
    _, _, highest = braking_distance(command, after, limit, change, dt)
    return dt * command + highest


@njit(cache=True)
def _stopping(joint_state, b, top, room, fraction):
    """Return the largest command from b to top that stops soon enough; b if none does."""
    if room == math.inf:
        return top
    start = _farthest(joint_state, b)
    if start > room:
        return b
    allowed = start + fraction * (room - start)
    if math.isinf(joint_state[1]) and math.isinf(joint_state[2]):
        return min(top, allowed / joint_state[3])
    if _farthest(joint_state, top) <= allowed:
        return top
    good, bad = b, top
    for _ in range(HALVINGS):
        middle = 0.5 * (good + bad)
        if _farthest(joint_state, middle) <= allowed:
            good = middle
        else:
            bad = middle
    return good


@njit(cache=True)
def advance_of(candidate, low, high, q, motion, limits, options, braking):
    """Fill `advance` of the :class:`Brake`: how far the stop moves per change of the command.

    It is the slope of the chord from the brake's command to the last velocity, so it is exact for a
    steady motion. At standstill it is the slope towards the candidate (n,).
    """
    dt = options[DT]
    for joint in range(len(q)):
        limit, change = limits[joint, ACCELERATION], limits[joint, JERK] * dt
        b, v = braking.command[joint], motion[0, joint]
        other = min(max(v, low[joint]), high[joint])
        if abs(other - b) <= STILL:
            other = min(max(candidate[joint], low[joint]), high[joint])
        if abs(other - b) <= STILL:
            other = high[joint] if high[joint] - b > b - low[joint] else low[joint]
        if abs(other - b) <= STILL or math.isinf(limit):
            braking.advance[joint] = dt
            continue
        end, _, _ = braking_distance(other, (other - v) / dt, limit, change, dt)
        moved = q[joint] + dt * other + end - braking.stop[joint]
        braking.advance[joint] = moved / (other - b)

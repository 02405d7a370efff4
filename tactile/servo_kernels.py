"""One compiled cycle of the servo: filters, PID per feature, eq. 15, projector, limits."""

from __future__ import annotations

import numpy as np
from numba import njit

from .stiffness import (
    CLEAR,
    EVENTS,
    EVIDENCE,
    FIRST,
    NOISE,
    REF_DEPTH,
    REF_PRESSURE,
    STARTED,
    STEP,
    STIFFNESS,
    TRAVEL,
    update_stiffness,
)

(
    WINDOW, ANGLE_WINDOW, PRESS_GAIN, SLIDE_GAIN, ROLL_GAIN, TURN_GAIN, ROLL_RATIO, SLIDE_SHARE,
    PRESS_INTEGRAL, SLIDE_INTEGRAL, PRESS_LEAD, SLIDE_LEAD, PRESS_SPEED, RETREAT_SPEED,
    SLIDE_SPEED, ROLL_SPEED, TURN_SPEED, INTEGRAL_SHARE, ANTI_WINDUP, LOW, HIGH, ADAPT, ARM_LAG,
    LATENCY, ROW_4, PRESS_BAND, SLIDE_BAND, LEAST_AREA,
) = range(28)  # fmt: skip
"""Places in the settings."""

(
    SUM_X, SUM_Y, SUM_P, LAST_X, LAST_Y, LAST_P, HAS_LAST, LAST_ANGLE, HAS_ANGLE, COUNT, CYCLE,
    DEPTH, ARM_Z, LOST_FOR, PRESSURE, ORIENTATION, CONFIDENCE, LANDED,
) = range(18)  # fmt: skip
"""Places in the memory: integrals (m/s), last errors, the angle's last error, samples in the
averages, cycles so far, way along z (m), modelled arm velocity along z (m/s), time without contact
(s), the filtered features, and whether the pressure has been near its goal since the touch."""

MEMORY = 18
"""How many there are."""

PRESSURES, DEPTHS, COSINES, SINES, COMMANDS = range(5)
"""Rows of the rings."""

FORGET_AFTER = 0.2
"""Time without contact after which the stiffness is guessed anew, s: what is touched next may be
another object; a flicker shorter than this is the same."""
BRANCH_MARGIN = np.radians(10.0)
"""How far beyond 90° an angle's error keeps its sign: noise at 90° must not flip the turning."""
OWN_MOTION = 0.3
"""Share of the expected answer of the pressure below which the object has moved by itself."""
STRIP = 1.0 / 12.0
"""Second moment of a square over its area squared: the centre of pressure of a flat contact moves
by area/12 (dp/dz)/p per tilt."""


@njit(cache=True)
def servo_cycle(
    settings, stiffness_settings, stiffness, memory, rings, selection, goal, external, measured,
    touching, centre, value, area, orientation, confidence, dt, out,
):  # fmt: skip
    """Fill ``out`` (6,) with the sensor twist of one cycle.

    ``goal`` (4,) is x, y (m), pressure (Pa), orientation (rad); ``value`` the measured pressure;
    ``measured`` (6,) the twist the sensor moved with since the last cycle, NaN where unknown;
    everything else is the state that the servo owns. Gives whether something was not finite;
    then nothing has changed.
    """
    total = dt + value + area + orientation + confidence
    for axis in range(6):
        total += external[axis]
    if not (dt > 0.0 and np.isfinite(total + centre[0] + centre[1])):
        return True
    _move(settings, memory, rings, measured, centre, dt)
    out[:] = 0.0
    if touching:
        trust = confidence if area >= settings[LEAST_AREA] else 0.0
        _filter(settings, memory, rings, value, orientation, trust)
        memory[LOST_FOR] = 0.0
        _slide_and_roll(settings, stiffness, memory, selection, goal, centre, area, dt, out)
        _press(settings, stiffness, memory, selection, goal, memory[PRESSURE], dt, out)
        _turn(settings, memory, selection, goal, dt, out)
        if settings[ADAPT] > 0.0:
            _estimate(stiffness_settings, stiffness, memory, rings, settings, out, area, dt)
        along_normal = out[2]
        # Turning about the centre of pressure, not about the origin: v -= ω x c.
        out[0] += out[5] * centre[1]
        out[1] -= out[5] * centre[0]
        out[2] -= out[3] * centre[1] - out[4] * centre[0]
    else:
        _lose(settings, stiffness_settings, stiffness, memory, dt)
        if settings[ANTI_WINDUP] == 0.0:
            _press(settings, stiffness, memory, selection, goal, 0.0, dt, out)
        along_normal = out[2]
    for axis in range(6):
        out[axis] += external[axis]
    rings[COMMANDS, int(memory[CYCLE]) % rings.shape[1]] = along_normal + external[2]
    memory[CYCLE] += 1.0
    return False


@njit(cache=True)
def _move(settings, memory, rings, measured, centre, dt):
    """Follow the contact point along z: as measured, else as the arm should have followed."""
    along = measured[2] + measured[3] * centre[1] - measured[4] * centre[0]
    # One that is not finite would stay in the depth for ever.
    if np.isfinite(along):
        memory[ARM_Z] = along
    else:
        cycle = int(memory[CYCLE]) - 1 - int(settings[LATENCY])
        command = rings[COMMANDS, cycle % rings.shape[1]] if cycle >= 0 else 0.0
        lag = settings[ARM_LAG]
        memory[ARM_Z] += (command - memory[ARM_Z]) * (1.0 - np.exp(-dt / lag) if lag > 0 else 1.0)
    memory[DEPTH] += memory[ARM_Z] * dt


@njit(cache=True)
def _filter(settings, memory, rings, value, orientation, confidence):
    """Average pressure and depth alike, and the orientation in the doubled angle."""
    place = int(memory[COUNT]) % rings.shape[1]
    rings[PRESSURES, place] = value
    rings[DEPTHS, place] = memory[DEPTH]
    rings[COSINES, place] = confidence * np.cos(2.0 * orientation)
    rings[SINES, place] = confidence * np.sin(2.0 * orientation)
    memory[COUNT] += 1.0
    memory[PRESSURE] = _average(rings, PRESSURES, memory[COUNT], settings[WINDOW])
    cosine = _average(rings, COSINES, memory[COUNT], settings[ANGLE_WINDOW])
    sine = _average(rings, SINES, memory[COUNT], settings[ANGLE_WINDOW])
    memory[ORIENTATION] = 0.5 * np.arctan2(sine, cosine)
    # Directions that disagree shorten their mean: scatter lowers the confidence too.
    memory[CONFIDENCE] = np.sqrt(cosine * cosine + sine * sine)


@njit(cache=True)
def _average(rings, row, count, window):
    samples = int(min(count, window))
    total = 0.0
    for back in range(1, samples + 1):
        total += rings[row, (int(count) - back) % rings.shape[1]]
    return total / samples


@njit(cache=True)
def _slide_and_roll(settings, stiffness, memory, selection, goal, centre, area, dt, out):
    """Rows 1, 2, 4 and 5 of eq. 15 on the deviation of the centre of pressure."""
    ratio = settings[ROLL_RATIO]
    tilt_gain = STRIP * area * stiffness[STIFFNESS]
    if tilt_gain > 0.0:
        ratio = min(ratio, settings[ROLL_GAIN] * memory[PRESSURE] / tilt_gain)
    for axis in range(2):
        roll = 4 - axis
        error = centre[axis] - goal[axis]
        if selection[axis] > 0.0:
            gain = settings[SLIDE_GAIN]
            if selection[roll] > 0.0:
                gain *= settings[SLIDE_SHARE]
            out[axis] = _pid(
                memory, SUM_X + axis, LAST_X + axis, error, gain,
                settings[SLIDE_INTEGRAL], settings[SLIDE_BAND], settings[SLIDE_LEAD],
                -settings[SLIDE_SPEED], settings[SLIDE_SPEED], settings[INTEGRAL_SHARE],
                settings[ANTI_WINDUP], dt, memory[HAS_LAST],
            )  # fmt: skip
        else:
            # What is switched on later must not take the way until then for a jump.
            memory[LAST_X + axis] = error
        if selection[roll] > 0.0:
            sign = settings[ROW_4] if roll == 3 else 1.0
            speed = sign * ratio * error
            out[roll] = min(max(speed, -settings[ROLL_SPEED]), settings[ROLL_SPEED])


@njit(cache=True)
def _press(settings, stiffness, memory, selection, goal, pressure, dt, out):
    """Row 3 of eq. 15: along z, towards the object, while the pressure is too low."""
    if abs(goal[2] - pressure) <= settings[PRESS_BAND] * goal[2]:
        memory[LANDED] = 1.0
    if selection[2] > 0.0:
        out[2] = _pid(
            memory, SUM_P, LAST_P, goal[2] - pressure, settings[PRESS_GAIN] / stiffness[STIFFNESS],
            settings[PRESS_INTEGRAL], settings[PRESS_BAND] * goal[2], settings[PRESS_LEAD],
            -settings[RETREAT_SPEED], settings[PRESS_SPEED], settings[INTEGRAL_SHARE],
            settings[ANTI_WINDUP], dt, memory[HAS_LAST],
        )  # fmt: skip
    else:
        memory[LAST_P] = goal[2] - pressure
    memory[HAS_LAST] = 1.0


@njit(cache=True)
def _pid(
    memory, total, last, error, gain, integral_time, band, lead, low, high, share, tame, dt, known
):
    """Eq. 13 of one feature; gain in (m/s) per unit of the error; limits in m/s.

    Tamed, the integral grows only near the goal and within the speed limit; far from it, an error
    that opposes it wears it down to zero.
    """
    slope = (error - memory[last]) / dt if known > 0.0 else 0.0
    memory[last] = error
    wish = gain * (error + lead * slope) + memory[total]
    growth = gain / integral_time * error * dt
    if tame > 0.0:
        before = memory[total]
        if abs(error) <= band:
            if not ((wish > high and growth > 0.0) or (wish < low and growth < 0.0)):
                memory[total] = min(max(before + growth, share * low), share * high)
        elif before * growth < 0.0:
            # Kept, it would hold a steady error that the proportional part just balances.
            memory[total] = before + growth if abs(growth) < abs(before) else 0.0
    else:
        memory[total] += growth
    return min(max(wish, low), high)


@njit(cache=True)
def _turn(settings, memory, selection, goal, dt, out):
    """Row 6 of eq. 15: proportional only, modulo π, and weighted by the confidence."""
    if selection[5] == 0.0:
        memory[HAS_ANGLE] = 0.0
        return
    trust = (memory[CONFIDENCE] - settings[LOW]) / (settings[HIGH] - settings[LOW])
    trust = min(max(trust, 0.0), 1.0)
    error = _half_turn(memory[ORIENTATION] - goal[3])
    if memory[HAS_ANGLE] > 0.0:
        near = memory[LAST_ANGLE] + _half_turn(error - memory[LAST_ANGLE])
        if abs(near) <= 0.5 * np.pi + BRANCH_MARGIN:
            error = near
    memory[HAS_ANGLE] = 1.0 if trust > 0.0 else 0.0
    memory[LAST_ANGLE] = error
    speed = trust * settings[TURN_GAIN] * error
    out[5] = min(max(speed, -settings[TURN_SPEED]), settings[TURN_SPEED])


@njit(cache=True)
def _half_turn(angle):
    """Angle modulo π, in (-π/2, π/2]."""
    return angle - np.pi * np.ceil(angle / np.pi - 0.5)


@njit(cache=True)
def _estimate(stiffness_settings, stiffness, memory, rings, settings, out, area, dt):
    """Stiffness from the averages of pressure and depth, which lag alike."""
    rolled = 0.5 * np.sqrt(area) * np.sqrt(out[3] * out[3] + out[4] * out[4]) * dt
    depth = _average(rings, DEPTHS, memory[COUNT], settings[WINDOW])
    travel = depth - stiffness[REF_DEPTH]
    expected = stiffness[STIFFNESS] * abs(travel)
    answer = (memory[PRESSURE] - stiffness[REF_PRESSURE]) * np.sign(travel)
    clear = (
        abs(travel) >= stiffness_settings[STEP] and expected >= CLEAR * stiffness_settings[NOISE]
    )
    if clear and memory[LANDED] > 0.0 and answer < OWN_MOTION * expected:
        # The object comes or goes by itself: taken for softness, that would raise the gain. Like
        # rolling it is no evidence.
        rolled = np.inf
    update_stiffness(stiffness, stiffness_settings, memory[PRESSURE], depth, rolled)


@njit(cache=True)
def _lose(settings, stiffness_settings, stiffness, memory, dt):
    """Forget what belonged to the contact that is gone."""
    memory[LOST_FOR] += dt
    memory[COUNT] = 0.0
    memory[HAS_ANGLE] = 0.0
    memory[LANDED] = 0.0
    memory[PRESSURE] = 0.0
    memory[CONFIDENCE] = 0.0
    stiffness[STARTED] = 0.0
    if settings[ANTI_WINDUP] > 0.0:
        memory[HAS_LAST] = 0.0
        for place in (SUM_X, SUM_Y, SUM_P):
            memory[place] = 0.0
    if memory[LOST_FOR] > FORGET_AFTER:
        stiffness[STIFFNESS] = stiffness_settings[FIRST]
        stiffness[EVIDENCE] = stiffness_settings[TRAVEL] ** 2
        stiffness[EVENTS] = 0.0

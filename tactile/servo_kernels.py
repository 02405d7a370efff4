"""The servo law, compiled: filter, PID per feature (13), inverse Jacobian (15), speed limits."""

from __future__ import annotations

import numpy as np
from numba import njit
from numba.np.unsafe.ndarray import to_fixed_tuple

from .pid import PidLaw, pid_speed
from .place_estimate import lose_place
from .servo_filters import average, coming_travel, filter_contact, track_depth, with_true_place
from .servo_memory import (
    COMMANDS,
    CONFIDENCE,
    COUNT,
    CYCLE,
    DEPTHS,
    GOAL_START,
    HAS_ANGLE,
    HAS_LAST,
    INTEGRAL_P,
    INTEGRAL_X,
    LANDED,
    LAST_ANGLE,
    LAST_P,
    LAST_X,
    LOST_FOR,
    ORIENTATION,
    PLACE_START,
    PRESSURE,
    SELECTION_START,
    SETTLED,
    STIFFNESS_START,
)
from .servo_tuples import SETTINGS, Contact, ServoArrays, ServoSettings
from .stiffness import (
    REF_DEPTH,
    REF_PRESSURE,
    STARTED,
    STIFFNESS,
    min_travel,
    reset_stiffness,
    update_stiffness,
)

RETREAT_SPEED = 0.05
"""Speed limit away from the object, m/s."""
MAX_ROLL_RATIO = 40.0
"""Upper bound of the angular velocity per offset of the centre of pressure, rad/(m s)."""
FOLLOWED, GONE, SAFE_SPEED = 0.6, 0.75, 0.003
"""Error of the pressure, as a share of the goal, up to which a landed pad follows an object with
its full gain, and from which the object may have left. The foam's memory then looks like a light
contact, so the proportional part is as slow as in a landing, but it may always command this last
speed, m/s."""
PRESS_BAND = 0.2
"""Error of the pressure within which its integral grows, as a share of the goal. A wider band
compensates faster drifts and overshoots more after contact."""
REST_SECONDS = 0.3
"""Time after landing at which pressing has its full gain, s. While the imprint of a pen grows, its
stiffness is underestimated."""
SLIDE_BAND = 0.002
"""Error of the centre of pressure within which its integral grows, m."""
ESTIMATE_BAND, ESTIMATE_SHARE = 5e-4, 0.7
"""Error of an estimated place below which a landed pad slides with a share of its gain, m, and the
share. The estimate wanders by 0.1 mm with the wrist's noise, and each motion after it bends the
foam, which changes the pressure. On a pen with `real`, it varied by 0.0114 of its goal without it,
and by 0.0097 with it."""
LOW_CONFIDENCE, HIGH_CONFIDENCE = 0.25, 0.6
"""Confidence of the orientation up to which the pad does not turn, and from which it turns with
the full gain."""
FORGET_SECONDS = 0.2
"""Time without contact after which the stiffness estimate starts anew, s. The next contact may be
another object. After a shorter interruption, it is the same object."""
BRANCH_MARGIN = np.radians(10.0)
"""Range beyond 90° in which the error of the angle keeps its sign, rad. Without it, noise at 90°
reverses the direction of turning."""
SETTLE_SECONDS = 0.1
"""Maximum time after landing for which the pressure is predicted, s. A loop that oscillates would
otherwise be predicted for ever, and hide that its gain is too high."""
SETTLED_SHARE = 0.05
"""Predicted rise of the pressure after landing below which the pad has come to rest, as a share of
the goal."""
WIDE_AREA, THIN_SHARE = 6e-4, 0.2
"""Area from which on a pad lands with the full press speed, m², and the minimum share of the speed
below it. With the sensor `real`, a probe of 2 mm overloaded the pad in 8 of 20 landings without
this, and in none with it; the response on a soft ball rose from 0.32 to 0.39 s."""
OWN_MOTION_SHARE = 0.3
"""Share of the expected change of pressure below which the object itself has moved."""
TILT_MOMENT = 1.0 / 12.0
"""Second moment of a square over its squared area. On a flat contact, a tilt moves the centre of
pressure by area/12 (dp/dz)/p per radian."""


@njit(cache=True)
def servo_cycle(settings, state, rings, contact, external, measured, dt, out):
    """Compute the sensor twist of one cycle, eqs. (13) and (15).

    Parameters
    ----------
    settings
        The values of `ServoSettings` as an array.
    state
        (STATE_SIZE,): memory, stiffness, selection, goal and place of `ServoArrays`.
    rings
        (RING_ROWS, MAX_WINDOW), ring buffers of `ServoArrays`.
    contact
        The values of `Contact` as a plain tuple. Numba needs 9 µs to accept a named tuple from
        Python, but less than 0.1 µs for a plain one.
    external
        (6,), external twist, which is added.
    measured
        (6,), twist of the sensor since the last cycle; NaN where unknown.
    dt
        Time since the last cycle, s.
    out
        (6,), filled with the twist.

    Returns
    -------
    bool
        Whether an input is not finite or dt is not positive; then nothing has changed.
    """
    s = ServoSettings(*to_fixed_tuple(settings, SETTINGS))  # pyright: ignore[reportCallIssue] - numba fills in the typing context
    a = ServoArrays(
        state[:STIFFNESS_START],
        rings,
        state[STIFFNESS_START:SELECTION_START],
        state[SELECTION_START:GOAL_START],
        state[GOAL_START:PLACE_START],
        state[PLACE_START:],
    )
    c = Contact(*contact)
    total = dt + c.pressure + c.area + c.orientation + c.confidence
    for axis in range(6):
        total += external[axis]
    if not (dt > 0.0 and np.isfinite(total + c.centre[0] + c.centre[1])):
        return True
    track_depth(s, a, measured, c.centre, dt)
    out[:] = 0.0
    if c.touching:
        if s.shear_lever > 0.0 and np.isfinite(np.sum(measured)):
            c = with_true_place(s, a, c, measured, dt)
        filter_contact(s, a, c)
        a.memory[LOST_FOR] = 0.0
        _slide_and_roll(s, a, c, dt, out)
        pressure = a.memory[PRESSURE]
        if a.memory[SETTLED] == 0.0 and s.anti_windup > 0.0:
            # Later the prediction would bias the pressure on an object that moves.
            rise = a.stiffness[STIFFNESS] * coming_travel(s, a, dt)
            pressure += rise
            landed = a.memory[LANDED]
            if landed > SETTLE_SECONDS or (landed > 0.0 and rise <= SETTLED_SHARE * a.goal[2]):
                a.memory[SETTLED] = 1.0
        _press(s, a, pressure, c.area, dt, out)
        _turn(s, a, out)
        if s.estimates_stiffness > 0.0:
            _estimate_stiffness(s, a, c.area, dt, out)
        along_normal = out[2]
        # The pad rotates about the centre of pressure, not about its origin: v -= ω x c.
        out[0] += out[5] * c.centre[1]
        out[1] -= out[5] * c.centre[0]
        out[2] -= out[3] * c.centre[1] - out[4] * c.centre[0]
    else:
        _lose_contact(s, a, dt)
        lose_place(a.place)
        if s.anti_windup == 0.0:
            _press(s, a, 0.0, WIDE_AREA, dt, out)
        along_normal = out[2]
    for axis in range(6):
        out[axis] += external[axis]
    a.rings[COMMANDS, int(a.memory[CYCLE]) % a.rings.shape[1]] = along_normal + external[2]
    a.memory[CYCLE] += 1.0
    return False


@njit(cache=True)
def _slide_and_roll(settings, arrays, contact, dt, out):
    """Fill rows 1, 2, 4 and 5 of eq. (15) from the error of the centre of pressure."""
    memory, selection = arrays.memory, arrays.selection
    landed = memory[SETTLED] > 0.0
    ratio = MAX_ROLL_RATIO
    tilt_gain = TILT_MOMENT * contact.area * arrays.stiffness[STIFFNESS]
    if tilt_gain > 0.0:
        ratio = min(ratio, settings.roll_gain * memory[PRESSURE] / tilt_gain)
    for axis in range(2):
        roll = 4 - axis
        error = contact.centre[axis] - arrays.goal[axis]
        if selection[axis] > 0.0:
            gain = settings.slide_gain
            if selection[roll] > 0.0:
                gain *= settings.slide_share
            band = SLIDE_BAND
            if settings.shear_lever > 0.0:
                # An integral would follow the errors of the estimated place.
                band = 0.0
                gain *= ESTIMATE_SHARE if landed and abs(error) < ESTIMATE_BAND else 1.0
            top = settings.slide_speed
            law = PidLaw(gain, band, -top, top, settings.derivative_time)
            out[axis] = pid_speed(settings, memory, axis, error, law, dt)
        else:
            # When the axis is selected later, the derivative must not see this change as a jump.
            memory[LAST_X + axis] = error
        if selection[roll] > 0.0:
            sign = settings.roll_x_sign if roll == 3 else 1.0
            speed = sign * ratio * error
            out[roll] = min(max(speed, -settings.roll_speed), settings.roll_speed)


@njit(cache=True)
def _press(settings, arrays, pressure, area, dt, out):
    """Fill row 3 of eq. (15): towards the object while the pressure is too low.

    A pad that lands on a small area is slow. The mean pressure on a thin probe hardly grows with
    the depth, until the foam stiffens within half a millimetre.
    """
    memory, goal = arrays.memory, arrays.goal[2]
    band = PRESS_BAND * goal
    # Only a measured pressure proves that the pad has landed.
    if memory[LANDED] > 0.0 or abs(goal - memory[PRESSURE]) <= band:
        memory[LANDED] += dt
    if arrays.selection[2] > 0.0:
        gain, lead = settings.press_gain, settings.derivative_time
        if memory[SETTLED] > 0.0:
            rested = min(memory[LANDED] / REST_SECONDS, 1.0) ** 2
            gain += (settings.rest_gain - gain) * rested
            lead *= 1.0 + rested
            error = (goal - pressure) / goal
            if error > FOLLOWED:
                gone = min((error - FOLLOWED) / (GONE - FOLLOWED), 1.0)
                top = FOLLOWED * (gain + (settings.press_gain - gain) * gone)
                safe = SAFE_SPEED * arrays.stiffness[STIFFNESS] / goal
                gain = min(gain, max(top, safe) / error)
        gain /= arrays.stiffness[STIFFNESS]
        # While the pressure is predicted, its error stays small for long and would wind up.
        settled = memory[SETTLED] > 0.0 or settings.anti_windup == 0.0
        share = 1.0 if settled else min(max(area / WIDE_AREA, THIN_SHARE), 1.0)
        limit = share * settings.press_speed
        law = PidLaw(gain, band if settled else 0.0, -RETREAT_SPEED, limit, lead)
        out[2] = pid_speed(settings, memory, 2, goal - pressure, law, dt)
    else:
        memory[LAST_P] = goal - pressure
    memory[HAS_LAST] = 1.0


@njit(cache=True)
def _turn(settings, arrays, out):
    """Fill row 6 of eq. (15): proportional, modulo π, weighted by the confidence."""
    memory = arrays.memory
    if arrays.selection[5] == 0.0:
        memory[HAS_ANGLE] = 0.0
        return
    weight = (memory[CONFIDENCE] - LOW_CONFIDENCE) / (HIGH_CONFIDENCE - LOW_CONFIDENCE)
    weight = min(max(weight, 0.0), 1.0)
    error = _wrap_line_angle(memory[ORIENTATION] - arrays.goal[3])
    if memory[HAS_ANGLE] > 0.0:
        continued = memory[LAST_ANGLE] + _wrap_line_angle(error - memory[LAST_ANGLE])
        if abs(continued) <= 0.5 * np.pi + BRANCH_MARGIN:
            error = continued
    memory[HAS_ANGLE] = 1.0 if weight > 0.0 else 0.0
    memory[LAST_ANGLE] = error
    speed = weight * settings.turn_gain * error
    out[5] = min(max(speed, -settings.turn_speed), settings.turn_speed)


@njit(cache=True)
def _wrap_line_angle(angle):
    """Return the angle modulo π, in (-π/2, π/2]."""
    return angle - np.pi * np.ceil(angle / np.pi - 0.5)


@njit(cache=True)
def _estimate_stiffness(settings, arrays, area, dt, out):
    """Update the stiffness from the averages of pressure and depth, which have the same delay."""
    memory, stiffness = arrays.memory, arrays.stiffness
    rolled = 0.5 * np.sqrt(area) * np.sqrt(out[3] * out[3] + out[4] * out[4]) * dt
    depth = average(arrays.rings, DEPTHS, memory[COUNT], settings.window)
    travel = depth - stiffness[REF_DEPTH]
    expected = stiffness[STIFFNESS] * abs(travel)
    change = (memory[PRESSURE] - stiffness[REF_PRESSURE]) * np.sign(travel)
    if (
        abs(travel) >= min_travel(stiffness)
        and memory[LANDED] > 0.0
        and change < OWN_MOTION_SHARE * expected
    ):
        # The object itself moves. Taken as softness, that would raise the gain. An infinite
        # rolled distance excludes the measurement.
        rolled = np.inf
    update_stiffness(stiffness, memory[PRESSURE], depth, rolled)


@njit(cache=True)
def _lose_contact(settings, arrays, dt):
    """Clear the state of the contact that is lost."""
    memory, stiffness = arrays.memory, arrays.stiffness
    memory[LOST_FOR] += dt
    memory[COUNT] = 0.0
    memory[HAS_ANGLE] = 0.0
    memory[LANDED] = 0.0
    memory[SETTLED] = 0.0
    memory[PRESSURE] = 0.0
    memory[CONFIDENCE] = 0.0
    stiffness[STARTED] = 0.0
    if settings.anti_windup > 0.0:
        memory[HAS_LAST] = 0.0
        memory[INTEGRAL_X : INTEGRAL_P + 1] = 0.0
    if memory[LOST_FOR] > FORGET_SECONDS:
        reset_stiffness(stiffness, settings.initial_stiffness)

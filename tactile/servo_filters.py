"""Averages of the contact features, and the motion that the averages do not show yet, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from .place_estimate import estimate_place
from .servo_memory import (
    ARM_Z,
    COMMANDS,
    CONFIDENCE,
    COSINES,
    COUNT,
    CYCLE,
    DEPTH,
    DEPTHS,
    MEASURED,
    ORIENTATION,
    PLACES,
    PRESSURE,
    PRESSURES,
    SINES,
    SPEEDS,
)
from .servo_tuples import Contact

COMMAND_CYCLES = 1
"""Cycles of the latency from a command to the motion. The others are the wait of the image."""
MIN_ORIENTATION_AREA = 1.5e-4
"""Minimum area of an imprint with a meaningful orientation, m². Two touched tactels always form a
line."""


@njit(cache=True)
def track_depth(settings, arrays, measured, centre, dt):
    """Integrate the motion of the contact point along z, measured or modelled."""
    memory, rings = arrays.memory, arrays.rings
    along = measured[2] + measured[3] * centre[1] - measured[4] * centre[0]
    # A value that is not finite would stay in the depth for ever.
    if np.isfinite(along):
        # The pressure is that of an older image, so the depth must be as old.
        cycle = int(memory[CYCLE])
        rings[SPEEDS, cycle % rings.shape[1]] = along
        memory[ARM_Z] = rings[SPEEDS, (cycle - _image_age(settings)) % rings.shape[1]]
        memory[MEASURED] = 1.0
    else:
        memory[MEASURED] = 0.0
        cycle = int(memory[CYCLE]) - 1 - int(settings.latency)
        command = rings[COMMANDS, cycle % rings.shape[1]] if cycle >= 0 else 0.0
        lag = settings.arm_lag
        memory[ARM_Z] += (command - memory[ARM_Z]) * (1.0 - np.exp(-dt / lag) if lag > 0 else 1.0)
    memory[DEPTH] += memory[ARM_Z] * dt


@njit(cache=True)
def coming_travel(settings, arrays, dt):
    """Return the travel along z that the averaged pressure does not show yet, m.

    If all commands were zero from now on, the pad would still move: by its present speed times the
    lag, and by the command that has not reached the arm. The average itself is as old as half its
    window, and the image by its wait (Smith, Chem. Eng. Prog. 53, 1957).
    """
    memory, rings = arrays.memory, arrays.rings
    size = rings.shape[1]
    travel = memory[DEPTH] - average(rings, DEPTHS, memory[COUNT], settings.window)
    cycle, speed = int(memory[CYCLE]), memory[ARM_Z]
    if memory[MEASURED] > 0.0:
        speed = rings[SPEEDS, cycle % size]
        for back in range(int(_image_age(settings))):
            travel += rings[SPEEDS, (cycle - back) % size] * dt
        pending = COMMAND_CYCLES
    else:
        pending = int(settings.latency)
    for back in range(1, min(pending, cycle) + 1):
        travel += rings[COMMANDS, (cycle - back) % size] * dt
    return travel + settings.arm_lag * speed


@njit(cache=True)
def _image_age(settings):
    """Return the age of an image when it arrives, cycles: all delay but that of the command."""
    return max(int(settings.latency) - COMMAND_CYCLES, 0)


@njit(cache=True)
def with_true_place(settings, arrays, contact, measured, dt):
    """Return the contact with the estimate of its true place in the place of its centre."""
    centre = contact.centre.copy()
    estimate_place(
        arrays.place,
        arrays.rings[PLACES:],
        int(arrays.memory[CYCLE]),
        contact.centre,
        contact.force,
        measured,
        (settings.shear_lever, float(_image_age(settings)), dt),
        centre,
    )
    return Contact(
        contact.touching,
        centre,
        contact.pressure,
        contact.area,
        contact.orientation,
        contact.confidence,
        contact.force,
    )


@njit(cache=True)
def filter_contact(settings, arrays, contact):
    """Average pressure and depth with one window, and the orientation in the doubled angle."""
    memory, rings = arrays.memory, arrays.rings
    weight = contact.confidence if contact.area >= MIN_ORIENTATION_AREA else 0.0
    place = int(memory[COUNT]) % rings.shape[1]
    rings[PRESSURES, place] = contact.pressure
    rings[DEPTHS, place] = memory[DEPTH]
    rings[COSINES, place] = weight * np.cos(2.0 * contact.orientation)
    rings[SINES, place] = weight * np.sin(2.0 * contact.orientation)
    memory[COUNT] += 1.0
    memory[PRESSURE] = average(rings, PRESSURES, memory[COUNT], settings.window)
    cosine = average(rings, COSINES, memory[COUNT], settings.orientation_window)
    sine = average(rings, SINES, memory[COUNT], settings.orientation_window)
    memory[ORIENTATION] = 0.5 * np.arctan2(sine, cosine)
    # Directions that differ shorten their mean vector, which lowers the confidence.
    memory[CONFIDENCE] = np.sqrt(cosine * cosine + sine * sine)


@njit(cache=True)
def average(rings, row, count, window):
    """Return the mean of the last samples of a row of the rings."""
    samples = int(min(count, window))
    total = 0.0
    for back in range(1, samples + 1):
        total += rings[row, (int(count) - back) % rings.shape[1]]
    return total / samples

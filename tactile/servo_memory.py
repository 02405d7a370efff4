"""Layout of the servo's state and ring buffers, shared by its compiled functions."""

from __future__ import annotations

from .place_estimate import PLACE_SIZE

(
    INTEGRAL_X, INTEGRAL_Y, INTEGRAL_P, LAST_X, LAST_Y, LAST_P, HAS_LAST, LAST_ANGLE, HAS_ANGLE,
    COUNT, CYCLE, DEPTH, ARM_Z, LOST_FOR, PRESSURE, ORIENTATION, CONFIDENCE, LANDED,
    MEASURED, SETTLED,
) = range(20)  # fmt: skip
"""Indices of the memory: integral parts (m/s), last errors of x, y (m) and pressure (Pa) and
whether they exist, last error of the angle (rad) and whether it exists, samples in the averages,
number of cycles, position along z (m), modelled arm velocity along z (m/s), time without contact
(s), the averaged features, the time since the pressure was near its goal (s, 0 before), whether the
arm measures its motion, and whether the pad has come to rest since the landing."""

STIFFNESS_START, SELECTION_START, GOAL_START, PLACE_START = 20, 28, 34, 38
STATE_SIZE = PLACE_START + PLACE_SIZE
"""Starts of the parts of the state after the memory, and its length. One array costs less at the
call than four."""

PRESSURES, DEPTHS, COSINES, SINES, COMMANDS, SPEEDS, PLACES = range(7)
"""Rows of the ring buffers; the place estimate has four rows from the last one on."""
RING_ROWS = 11
"""Number of rows of the ring buffers."""

"""Named tuples that the compiled servo law reads: settings, state, contact."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class ServoSettings(NamedTuple):
    """Constants of one servo, from its options; all are float64, in one array."""

    window: float
    """Samples of the pressure average."""
    orientation_window: float
    """Samples of the orientation average."""
    press_gain: float
    """Loop gain of pressing while the pad lands, 1/s; the gain Kp is this over the stiffness."""
    rest_gain: float
    """The same after the landing, 1/s."""
    slide_gain: float
    """Loop gain of sliding, 1/s."""
    roll_gain: float
    """Loop gain of rolling, 1/s."""
    turn_gain: float
    """Loop gain of turning, 1/s."""
    slide_share: float
    """Share of the sliding gain along an axis where rolling is selected."""
    roll_x_sign: float
    """Sign of row 4 of eq. (15)."""
    integral_time: float
    """s."""
    derivative_time: float
    """s."""
    press_speed: float
    """m/s."""
    slide_speed: float
    """m/s."""
    roll_speed: float
    """rad/s."""
    turn_speed: float
    """rad/s."""
    anti_windup: float
    """1 if the integrals are bounded, and cleared when contact is lost, else 0."""
    estimates_stiffness: float
    """1 if the stiffness is estimated, else 0."""
    initial_stiffness: float
    """Pa/m."""
    arm_lag: float
    """s."""
    latency: float
    """Cycles, a whole number."""
    shear_lever: float
    """m; 0 takes the measured centre of pressure as the place."""


SETTINGS = len(ServoSettings._fields)


class ServoArrays(NamedTuple):
    """State and targets of one servo, as views."""

    memory: NDArray[np.float64]
    """(18,), see `servo_memory.INTEGRAL_X` and the following."""
    rings: NDArray[np.float64]
    """(RING_ROWS, MAX_WINDOW), the last samples of `servo_memory.PRESSURES` and the following."""
    stiffness: NDArray[np.float64]
    """(8,), state of the stiffness estimate."""
    selection: NDArray[np.float64]
    """(6,), diagonal of the projector P."""
    goal: NDArray[np.float64]
    """(4,): x, y (m), pressure (Pa), orientation (rad)."""
    place: NDArray[np.float64]
    """(7,), state of `place_estimate`."""


class Contact(NamedTuple):
    """The features of one cycle."""

    touching: bool
    """Whether there is a contact."""
    centre: NDArray[np.float64]
    """(3,), m."""
    pressure: float
    """Pa; with a goal of force, the force over the reference area."""
    area: float
    """m²."""
    orientation: float
    """rad."""
    confidence: float
    """0..1."""
    force: float
    """N."""

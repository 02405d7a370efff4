"""The tactile servo: from contact features to a twist of the sensor, eqs. (13) and (15)."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .features import ContactFeatures
from .image import tangents
from .place_estimate import AGE, PLACE_X, PLACE_Y, SIDE_X, SIDE_Y
from .selection import TRACK, SelectionMatrix
from .servo_kernels import servo_cycle
from .servo_memory import (
    COMMANDS,
    CONFIDENCE,
    COUNT,
    CYCLE,
    GOAL_START,
    INTEGRAL_P,
    INTEGRAL_X,
    INTEGRAL_Y,
    ORIENTATION,
    PLACE_START,
    PRESSURE,
    RING_ROWS,
    SELECTION_START,
    STATE_SIZE,
    STIFFNESS_START,
)
from .servo_options import MAX_WINDOW, ORIENTATION_WINDOW, ServoOptions
from .servo_tuples import ServoSettings
from .stiffness import INITIAL_STIFFNESS, STIFFNESS, new_stiffness

REFERENCE_AREA = 1e-3
"""Area by which a force becomes a pressure, m², so that the bounds of dp/dz hold for both."""
SLIDE_SHARE = 0.02
"""Share of the sliding gain along an axis where rolling is selected. Sliding to the imprint of an
edge would remove the offset that rolling needs."""
ROLL_X_SIGN = -1.0
"""Sign of row 4 of eq. (15). With +1, as printed, rolling about x increases the tilt."""
MIN_INTEGRAL_DELAYS = 33.0
"""Minimum integral time, as a multiple of the latency. On a pen with the sensor `harsh`, the
pressure varied by 7 % with 0.3 s, and by 1 % with the 0.9 s that result from it. With 50, the
pressure of an approaching object rose too far."""
UNKNOWN_TWIST = np.full(6, np.nan)
"""The measured twist of an arm that does not measure it."""


@dataclass(frozen=True)
class ServoGoal:
    """The desired values of the features, in the sensor's frame.

    Raises
    ------
    InputError
        If a value is not finite, or pressure or force is not positive.
    """

    x: float = 0.0
    """Centre of pressure along x, m."""
    y: float = 0.0
    """Centre of pressure along y, m."""
    pressure: float = 1000.0
    """Mean pressure over the contact, Pa; used if no force is given."""
    force: float | None = None
    """Total force, N, in place of the pressure."""
    orientation: float = np.pi / 2
    """Direction of the imprint's long axis, rad, modulo π. The default is the sensor's y-axis."""

    def __post_init__(self) -> None:
        if not np.all(np.isfinite([self.x, self.y, self.orientation])):
            raise InputError(
                f"a goal must be finite, got {self.x}, {self.y} m, {self.orientation} rad"
            )
        press = self.pressure if self.force is None else self.force
        if not 0.0 < press < np.inf:
            raise InputError(f"a goal's pressure or force must be finite and > 0, got {press}")


@dataclass(frozen=True, slots=True)
class SensorTwist:
    """The sensor motion that the servo commands for one cycle."""

    twist: NDArray[np.float64]
    """[v; ω] in the sensor's frame, (6,), m/s and rad/s; includes the external twist."""
    touching: bool
    """Whether there was a contact. Without one, the twist is the external twist alone."""


class TactileServo:
    """Convert contact features to sensor twists, cycle by cycle; eqs. (13) and (15).

    The sensor's z-axis points towards the object. On a curved array, the servo works in the frame
    of the contact, whose z-axis is the contact's normal: a fingertip presses where it is touched.

    If the contact is too far along +x, the pad
    slides along +x and rolls about +y. If it is too far along +y, the pad slides along +y and rolls
    about **-x**. So row 4 of eq. (15) is -1 here: with +1, as printed, the rolling diverges.

    The pressure and the orientation are averaged (`ServoOptions.window`). The centre of pressure
    is not, because it is a mean over many tactels already.

    Parameters
    ----------
    goal
        Desired values of the features.
    selection
        Which twist components touch controls, the projector P.
    options
        Gains, filter, limits.
    """

    def __init__(
        self,
        goal: ServoGoal | None = None,
        selection: SelectionMatrix = TRACK,
        options: ServoOptions | None = None,
    ) -> None:
        self.options = options or ServoOptions()
        settings = _settings(self.options)
        self._initial_stiffness = settings.initial_stiffness
        self._settings = np.array(settings, dtype=np.float64)
        self._no_motion = np.zeros(6)
        self._state = np.zeros(STATE_SIZE)
        self._memory = self._state[:STIFFNESS_START]
        self._stiffness = self._state[STIFFNESS_START:SELECTION_START]
        self._selection_array = self._state[SELECTION_START:GOAL_START]
        self._goal_array = self._state[GOAL_START:PLACE_START]
        self._place = self._state[PLACE_START:]
        self._rings = np.zeros((RING_ROWS, MAX_WINDOW))
        self.reset()
        self.goal = goal or ServoGoal()
        self.selection = selection

    @property
    def goal(self) -> ServoGoal:
        """Desired values of the features; may be set between cycles."""
        return self._goal

    @goal.setter
    def goal(self, goal: ServoGoal) -> None:
        self._goal = goal
        self._goal_array[:] = goal.x, goal.y, self.goal_pressure, goal.orientation

    @property
    def selection(self) -> SelectionMatrix:
        """Which twist components touch controls; may be set between cycles."""
        return self._selection

    @selection.setter
    def selection(self, selection: SelectionMatrix) -> None:
        self._selection = selection
        self._selection_array[:] = astuple(selection)
        # The integral of a component that is not controlled must not act later.
        for place, axis in ((INTEGRAL_X, 0), (INTEGRAL_Y, 1), (INTEGRAL_P, 2)):
            self._memory[place] *= self._selection_array[axis]

    @property
    def goal_pressure(self) -> float:
        """Pressure of the goal, Pa; with a goal of force, that force over the reference area."""
        goal = self._goal
        return goal.pressure if goal.force is None else goal.force / REFERENCE_AREA

    def measured_pressure(self, features: ContactFeatures) -> float:
        """Return the pressure (Pa) that is compared with `goal_pressure`."""
        return features.pressure if self._goal.force is None else features.force / REFERENCE_AREA

    def step(
        self,
        features: ContactFeatures,
        dt: float,
        external: NDArray[np.float64] | None = None,
        measured: NDArray[np.float64] | None = None,
    ) -> SensorTwist:
        """Compute the sensor's twist for this cycle.

        Parameters
        ----------
        features
            The current contact features.
        dt
            Time since the last cycle, s, > 0.
        external
            External twist in the sensor's frame, (6,), m/s and rad/s, which is added; None is zero.
        measured
            Twist of the sensor since the last cycle, (6,), m/s and rad/s. None assumes the
            commanded twist with the lag of `ServoOptions.arm_lag`. It serves to estimate the
            stiffness.

        Returns
        -------
        SensorTwist
            Within the speed limits of the options, apart from the external twist.

        Raises
        ------
        InputError
            If `dt` is not positive, or a feature or the external twist is not finite.
        """
        out = np.empty(6)
        touching = features.force > 0.0
        centre = features.centre
        # A flat array's normal is exactly z. Then the frames of sensor and contact are equal.
        self._axes = contact_axes(features.normal) if features.normal[2] < 1.0 else None
        if self._axes is not None:
            centre = self._axes @ centre
            external = None if external is None else _turned(self._axes, external)
            measured = None if measured is None else _turned(self._axes, measured)
        contact = (
            touching, centre, self.measured_pressure(features), features.area,
            features.orientation, features.confidence, features.force,
        )  # fmt: skip
        bad = servo_cycle(
            self._settings,
            self._state,
            self._rings,
            contact,
            self._no_motion if external is None else external,
            UNKNOWN_TWIST if measured is None else measured,
            dt,
            out,
        )
        if bad:
            raise InputError(
                f"a cycle needs dt > 0 s, finite features and a finite external twist, got {dt}, "
                f"{features}, {external}"
            )
        if self._axes is not None:
            out = _turned(self._axes.T, out)
        return SensorTwist(out, touching)

    def reset(self) -> None:
        """Clear all memory of contacts."""
        self._memory[:] = 0.0
        self._rings[:] = 0.0
        self._axes = None
        self._place[:] = 0.0
        self.side_force = None
        self._stiffness[:] = new_stiffness(self._initial_stiffness)

    def set_sent_twist(self, twist: NDArray[np.float64]) -> None:
        """Correct the last command: the arm received this twist (6,) instead of the servo's."""
        cycle = int(self._memory[CYCLE]) - 1
        speed = twist[2] if self._axes is None else self._axes[2] @ twist[:3]
        self._rings[COMMANDS, cycle % MAX_WINDOW] = speed

    @property
    def side_force(self) -> NDArray[np.float64] | None:
        """Tangential force on the sensor, (2,), N, along x and y; None if the arm measures none.

        Set it before each cycle; it serves to estimate the place of the contact.
        """
        force = self._place[SIDE_X : SIDE_Y + 1]
        return force.copy() if np.isfinite(force).all() else None

    @side_force.setter
    def side_force(self, force: NDArray[np.float64] | None) -> None:
        self._place[SIDE_X : SIDE_Y + 1] = np.nan if force is None else force

    @property
    def place(self) -> NDArray[np.float64] | None:
        """Estimated true place of the contact when the last image was taken, (2,), m.

        None without contact, or without `ServoOptions.shear_lever`.
        """
        if self._place[AGE] == 0.0:
            return None
        return self._place[PLACE_X : PLACE_Y + 1].copy()

    @property
    def stiffness(self) -> float:
        """Estimated stiffness dp/dz of the contact, Pa/m; of force over the reference area too."""
        return float(self._stiffness[STIFFNESS])

    @property
    def filtered(self) -> tuple[float, float, float]:
        """Averaged pressure (Pa), orientation (rad) and its confidence; zero without contact."""
        memory = self._memory
        if memory[COUNT] == 0.0:
            return 0.0, 0.0, 0.0
        return float(memory[PRESSURE]), float(memory[ORIENTATION]), float(memory[CONFIDENCE])


def contact_axes(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the axes of the contact's frame as rows, (3, 3): two tangents and the normal."""
    return np.vstack([tangents(normal), normal])


def _turned(axes: NDArray[np.float64], twist: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a twist (6,) about the same point in other axes (3, 3)."""
    return (twist.reshape(2, 3) @ axes.T).ravel()


def _settings(options: ServoOptions) -> ServoSettings:
    known = options.known_stiffness
    return ServoSettings(
        window=options.window,
        orientation_window=ORIENTATION_WINDOW,
        press_gain=options.press_loop_gain(),
        rest_gain=options.rest_loop_gain(),
        slide_gain=options.slide_loop_gain(),
        roll_gain=options.roll_loop_gain(),
        turn_gain=options.turn_loop_gain(),
        slide_share=SLIDE_SHARE,
        roll_x_sign=ROLL_X_SIGN,
        integral_time=max(
            options.integral_time, MIN_INTEGRAL_DELAYS * options.latency / options.rate
        ),
        derivative_time=options.derivative_time,
        press_speed=options.press_speed,
        slide_speed=options.slide_speed,
        roll_speed=options.roll_speed,
        turn_speed=options.turn_speed,
        anti_windup=float(options.anti_windup),
        estimates_stiffness=float(known is None),
        initial_stiffness=INITIAL_STIFFNESS if known is None else known,
        arm_lag=options.arm_lag,
        latency=round(options.latency),
        shear_lever=options.shear_lever,
    )

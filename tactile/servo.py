"""The tactile servo: contact features to a twist of the sensor (eq. 13 and 15)."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .selection import TRACK, SelectionMatrix
from .servo_kernels import (
    COMMANDS,
    CONFIDENCE,
    COUNT,
    CYCLE,
    MEMORY,
    ORIENTATION,
    PRESSURE,
    SUM_P,
    SUM_X,
    SUM_Y,
    servo_cycle,
)
from .servo_options import MOST_SAMPLES, ServoOptions
from .stiffness import STIFFNESS, new_stiffness, stiffness_settings

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .features import ContactFeatures

UNKNOWN = np.full(6, np.nan)
"""The measured twist of an arm that tells none."""


@dataclass(frozen=True)
class ServoGoal:
    """Where the features should be, in the sensor's frame.

    Raises
    ------
    InputError
        If a value is not finite, or pressure or force is not positive.
    """

    x: float = 0.0
    """Centre of pressure along x, m."""
    y: float = 0.0
    """Along y, m."""
    pressure: float = 1000.0
    """Mean pressure over the contact, Pa; used if no force is given."""
    force: float | None = None
    """Total force, N, instead of the pressure."""
    orientation: float = np.pi / 2
    """Direction of the imprint's long axis, rad, modulo π; the default is the sensor's y-axis."""

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
    """What the servo asks of the sensor for one cycle."""

    twist: NDArray[np.float64]
    """[v; ω] in the sensor's frame, (6,), m/s and rad/s; outer motion included."""
    touching: bool
    """Whether there was a contact to act on; without one only the outer motion is left."""


class TactileServo:
    """Turn contact features into sensor twists, cycle by cycle.

    With z towards the object, a contact that is too far along +x wants the pad to slide along +x
    and to turn about +y; one too far along +y wants it to slide along +y and to turn about **-x**.
    So row 4 of eq. 15 is -1 here: with both +1, as printed, one of the two rolls runs away.

    Parameters
    ----------
    goal
        Where the features should be.
    switches
        What touch controls, the projector P.
    options
        Gains, filters, limits.
    """

    def __init__(
        self,
        goal: ServoGoal | None = None,
        selection: SelectionMatrix = TRACK,
        options: ServoOptions | None = None,
    ) -> None:
        self.options = options or ServoOptions()
        self._settings = _settings(self.options)
        self._stiffness_settings = stiffness_settings(self.options)
        self._goal_array = np.zeros(4)
        self._switch_array = np.zeros(6)
        self._external = np.zeros(6)
        self.reset()
        self.goal = goal or ServoGoal()
        self.selection = selection

    @property
    def goal(self) -> ServoGoal:
        """Where the features should be; may be set between cycles."""
        return self._goal

    @goal.setter
    def goal(self, goal: ServoGoal) -> None:
        self._goal = goal
        force = goal.force
        pressure = goal.pressure if force is None else force / self.options.reference_area
        self._goal_array[:] = goal.x, goal.y, pressure, goal.orientation

    @property
    def selection(self) -> SelectionMatrix:
        """What touch controls; may be set between cycles."""
        return self._selection

    @selection.setter
    def selection(self, selection: SelectionMatrix) -> None:
        self._selection = selection
        self._switch_array[:] = astuple(selection)
        # An integral that nothing wears down must not come back later.
        for place, on in ((SUM_X, 0), (SUM_Y, 1), (SUM_P, 2)):
            self._memory[place] *= self._switch_array[on]

    def step(
        self,
        features: ContactFeatures,
        dt: float,
        external: NDArray[np.float64] | None = None,
        measured: NDArray[np.float64] | None = None,
    ) -> SensorTwist:
        """Give the sensor's twist for this cycle.

        Parameters
        ----------
        features
            What the pad feels now.
        dt
            Time since the last cycle, s, > 0.
        external
            Outer motion in the sensor's frame, (6,), added as it is; none if left out.
        measured
            Twist the sensor moved with since the last cycle, (6,), m/s and rad/s; if left out,
            what was asked for, lagged as ``options.arm_lag`` says. The stiffness is estimated
            from it.

        Returns
        -------
        SensorTwist
            Within the speed limits of the options, the outer motion apart.

        Raises
        ------
        InputError
            If ``dt`` is not positive or a feature is not finite.
        """
        force = features.force
        if self._goal.force is None:
            value = features.pressure
        else:
            value = force / self.options.reference_area
        out = np.empty(6)
        touching = force > 0.0
        bad = servo_cycle(
            self._settings, self._stiffness_settings, self._stiffness, self._memory, self._rings,
            self._switch_array, self._goal_array,
            self._external if external is None else external,
            UNKNOWN if measured is None else measured,
            touching, features.centre, value, features.area, features.orientation,
            features.confidence, dt, out,
        )  # fmt: skip
        if bad:
            raise InputError(
                f"a cycle needs dt > 0 s, finite features and a finite outer motion, got {dt}, "
                f"{features}, {external}"
            )
        return SensorTwist(out, touching)

    def reset(self) -> None:
        """Forget all contacts, as at the start."""
        self._memory = np.zeros(MEMORY)
        self._rings = np.zeros((5, MOST_SAMPLES))
        self._stiffness = new_stiffness(self._stiffness_settings)

    def set_sent_twist(self, twist: NDArray[np.float64]) -> None:
        """Tell that not the last step's twist was sent to the arm but this one, (6,)."""
        cycle = int(self._memory[CYCLE]) - 1
        self._rings[COMMANDS, cycle % MOST_SAMPLES] = twist[2]

    @property
    def stiffness(self) -> float:
        """Estimated dp/dz of what is touched, Pa/m (of force over the reference area likewise)."""
        return float(self._stiffness[STIFFNESS])

    @property
    def filtered(self) -> tuple[float, float, float]:
        """Averaged pressure (Pa), orientation (rad) and its confidence; zero without contact."""
        memory = self._memory
        if memory[COUNT] == 0.0:
            return 0.0, 0.0, 0.0
        return float(memory[PRESSURE]), float(memory[ORIENTATION]), float(memory[CONFIDENCE])


def _settings(options: ServoOptions) -> NDArray[np.float64]:
    """Options in the order of the kernel's places."""
    return np.array(
        [
            options.window, options.orientation_window, options.press_loop_gain(),
            options.slide_loop_gain(), options.roll_loop_gain(), options.turn_loop_gain(),
            options.roll_ratio, options.slide_while_rolling, options.press_integral_time,
            options.slide_integral_time, options.press_derivative_time,
            options.slide_derivative_time, options.press_speed, options.retreat_speed,
            options.slide_speed, options.roll_speed, options.turn_speed, options.integral_share,
            float(options.anti_windup), options.confidence_low, options.confidence_high,
            float(options.adapt),
            options.arm_lag, round(options.latency), 1.0 if options.printed_signs else -1.0,
            options.press_integral_band, options.slide_integral_band,
            options.confidence_area,
        ],
        dtype=float,
    )  # fmt: skip

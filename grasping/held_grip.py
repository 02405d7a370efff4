"""The grip on a held object, by the load that the wrist measures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from eyehand.errors import InputError
from eyehand.tactile import FrictionPull, GripReading, LoadGrip, LoadGripOptions

from .hands.closing import Closing
from .hands.grip_regulator import GripRegulator
from .hands.hand_state import finger_reading

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .cell import Cell
    from .robot import RobotReading

GRAVITY = 9.81
"""Gravitational acceleration, m/s²."""
FRICTION_SHARE = 0.8
"""Share of the friction that the grip relies on."""
CAUTIOUS_FRICTION = FRICTION_SHARE * 0.3
"""Friction that the grip relies on until it is measured. Few pads are more slippery than 0.3."""
LAW = LoadGripOptions(reserve=2.5, relax_time=0.2)
"""Reserve and speed of the grip. The reserve holds the fingers' own mass against the object when
the arm jerks."""
MIN_WEIGHT = 0.4
"""Weight from which friction is measured, N: above the noise of the wrist."""
PUSH_FORCE = 0.5
"""Force from below from which the hand presses on a support, N, above the noise of the wrist. The
object then neither loads the pads, nor slips."""
MIN_GRIP = 3.0
"""Force of all pads together at which easing ends, N."""
MIN_FRICTION = 0.15
"""Measured friction below which noise ended the easing. No pad is so slippery."""
PATCH_RADIUS = 0.006
"""Radius at which the pad of one finger resists turning, m."""
ENOUGH_RATIO = 0.6
"""Ratio of load and grip at which easing ends, though the object sticks. Beyond it the grip becomes
so light that an object is lost before its slide is noticed."""
MAX_TURNING = 2.0
"""Maximum part of turning in the load, as a multiple of the force. An object that would turn more
hangs down instead."""
FILTER_SECONDS = 0.03
"""Time constant of the filter of the load, s."""
STEADY_SECONDS = 0.08
"""Time for which the load must be constant to be the weight, s."""
STEADY_SHARE, STEADY_FORCE = 0.03, 0.06
"""Maximum change of the load in this time, as a share and in N; the larger of the two counts."""
DROP_SHARE, DROP_FORCE = 0.25, 0.3
"""Loss of the load that is a slip, as a share of the weight and in N; the larger of the two
counts."""
DROP_SECONDS = 0.012
"""Time after which a loss of load is a slip, s."""
MEAN_SECONDS = 0.06
"""Time over which the wrist's measurement is averaged, s."""
SLIDE_SECONDS, SLIDE_EXCURSION = 0.04, 0.06e-3
"""Motion of a tendon that shows an object sliding while the grip is eased: time, s, and shortening,
m. A finger on an object that sticks moves outwards."""
CHATTER_SHARE, CHATTER_FORCE, CHATTER_SECONDS = 0.2, 0.3, 0.02
"""Deviation of the grip from its filtered value that shows an object sliding while the grip is
eased, as a share and in N, both added, and the time constant of the filter, s. An object that
slides bounces between the pads."""
SETTLING_SECONDS = 0.06
"""Time at the beginning of easing in which the fingers settle, s."""
CAUGHT_SHARE = 1.8
"""Grip that stops a sliding object, as a multiple of that at which it slid."""

Stage = Literal["load", "pull", "follow"]
"""Stage of the grip.

- load: the hand takes over the weight. The grip only rises, for a cautious friction.
- pull: the grip is eased until the object slides.
- follow: the grip follows the load, for the measured friction.
"""


class HeldGrip:
    """Adjust the grip to the load of the object, its friction, and slip.

    Parameters
    ----------
    closing
        The controller of the fingers, which holds the object.
    encloses
        Whether the whole hand encloses the object, instead of fingers and thumb holding it.
    offsets
        Position of each finger without the thumb along the palm's y axis, m.
    tare
        Measurement of the wrist with the empty hand in this orientation, (6,).
    reach
        Distance of the contacts from the palm along its z axis, m.
    """

    def __init__(
        self,
        closing: Closing,
        encloses: bool,
        offsets: Sequence[float] | NDArray[np.float64],
        tare: NDArray[np.float64],
        reach: float,
    ) -> None:
        self._regulator, self._encloses = GripRegulator(closing), encloses
        self._offsets = np.asarray(offsets)
        self._tare, self._grip_point = tare, np.array([0.0, 0.0, reach])
        self.stage: Stage = "load"
        self.friction: float | None = None
        """Measured friction; None if the object did not slide."""
        self.weight = 0.0
        """Weight that the hand carries, N; 0 before it is measured."""
        self.carrying = False
        """Whether the grip stays at least at its usual tension. The carry jerks the fingers."""
        self.slips = 0
        """Number of slips."""
        self.load = np.zeros(6)
        """Filtered wrench of the load at the grip point in the palm's axes, (6,), N and Nm."""
        self._law: LoadGrip | None = None
        self._pull: FrictionPull | None = None
        self._past: list[tuple[float, float]] = []
        self._eased: list[tuple[float, float, NDArray[np.float64]]] = []
        self._smooth = self._pull_start = 0.0
        self._drop = 0.0
        self._speed: float | None = None

    def update(self, cell: Cell, reading: RobotReading) -> None:
        """Adjust the grip to a reading. Without a measurement it returns to the usual tension."""
        if not cell.hand.holds(reading.hand):
            return
        dt = cell.robot.period
        measured = measured_wrench(reading)
        if measured is None:
            self._regulator.tighten_fully(dt)
            return
        wrench = self._about_grip_point(measured)
        self.load += (wrench - self.load) * (1.0 - np.exp(-dt / FILTER_SECONDS))
        forces = cell.hand.forces(reading.hand)
        pressed = self.pressed(forces)
        if self._law is None:
            self._law = self._new_law(CAUTIOUS_FRICTION, 0.0)
        palm = cell.arm_state()
        carried = -float((palm.rotation @ self.load[:3])[2])
        self._past.append((reading.time, carried))
        while self._past[1:] and self._past[1][0] <= reading.time - STEADY_SECONDS:
            self._past.pop(0)
        load = self._tangential(np.concatenate([wrench[:3], self.load[3:]]), forces)
        if self.stage == "load":
            # A hand that still presses on the support carries nothing.
            force = self._law.update(
                GripReading(pressed, load if carried > 0.0 else 0.0, False), dt
            )
            self._regulator.tighten(force, dt)
            return
        if self._pull is not None and self.stage == "pull":
            force = self._pull.update(pressed, load, dt)
            slid = self._slides(reading, pressed, load, dt)
            eased = pressed < MIN_GRIP or load > ENOUGH_RATIO * pressed
            if slid or self._pull.done or eased:
                # The arm of a turning load is not known. It is no proof of friction.
                reached = float(np.hypot(*self.load[1:3])) / max(self._smooth, 1e-3)
                self._end_pull(pressed, slid or self._pull.friction, reached)
        else:
            slipping = self._drops(cell, carried, float((palm.jacobian @ reading.velocity)[2]))
            pushes = self.pushed > PUSH_FORCE
            load = self.weight if pushes else max(load, self.weight)
            force = self._law.update(GripReading(pressed, load, slipping), dt)
        if self.carrying:
            self._regulator.tighten_fully(dt)
        else:
            self._regulator.press(force, pressed, dt)

    def pressed(self, forces: NDArray[np.float64]) -> float:
        """Return the force of all pads on the object, N, from those of fingers, thumb and palm.

        Fingertips hold what the thumb opposes. Other forces are those of fingers on their own palm,
        and of a thumb that a neighbour presses.
        """
        if self._encloses:
            return float(forces.sum())
        return 2.0 * float(min(forces[:-2].sum(), forces[-2]))

    def _slides(self, reading: RobotReading, pressed: float, load: float, dt: float) -> float:
        """Return the ratio of load and grip at which the object began to slide; 0 if it sticks."""
        time, tendons = reading.time, finger_reading(reading.hand).excursions
        if not self._eased:
            self._smooth, self._pull_start = pressed, time
        chatter = abs(pressed - self._smooth)
        self._smooth += (pressed - self._smooth) * (1.0 - np.exp(-dt / CHATTER_SECONDS))
        self._eased.append((time, load / max(self._smooth, 1e-3), tendons))
        while self._eased[1:] and self._eased[1][0] <= time - SLIDE_SECONDS:
            self._eased.pop(0)
        if time - self._pull_start < SETTLING_SECONDS:
            return 0.0
        closed = float((tendons - self._eased[0][2]).max())
        bounces = chatter > CHATTER_SHARE * self._smooth + CHATTER_FORCE
        if bounces or closed > SLIDE_EXCURSION:
            return max(ratio for _, ratio, _ in self._eased)
        return 0.0

    @property
    def steady(self) -> bool:
        """Whether the load has been constant for `STEADY_SECONDS`."""
        if len(self._past) < 2 or self._past[-1][0] - self._past[0][0] < 0.9 * STEADY_SECONDS:
            return False
        loads = [load for _, load in self._past]
        return loads[-1] > 0.0 and max(loads) - min(loads) < max(
            STEADY_SHARE * loads[-1], STEADY_FORCE
        )

    def weigh(self) -> None:
        """Take the load as the weight of the object."""
        self.weight = max(self._past[-1][1], 0.0) if self._past else 0.0

    def start_pull(self, pressed: float) -> None:
        """Ease the grip from now on, until the object slides."""
        self.stage = "pull"
        self._regulator.settle()
        self._pull = FrictionPull(pressed)

    def follow(self, pressed: float) -> None:
        """Follow the load from now on, without measuring the friction."""
        self.stage = "follow"
        self._regulator.settle()
        self._law = self._new_law(CAUTIOUS_FRICTION, pressed)

    @property
    def pushed(self) -> float:
        """Force with which a support pushes the hand up, N; 0 while it carries."""
        return max(-self._past[-1][1], 0.0) if self._past else 0.0

    @property
    def pulling(self) -> bool:
        """Whether the grip is still being eased."""
        return self.stage == "pull"

    def _end_pull(self, pressed: float, friction: float | None, reached: float) -> None:
        """Follow the load for a friction; None if the object stuck at the reached ratio."""
        if friction is not None and friction < MIN_FRICTION:
            friction = None
        self.stage, self.friction = "follow", friction
        assert self._pull is not None, "the pull has begun"
        if friction is None:
            reliable = max(FRICTION_SHARE * reached, CAUTIOUS_FRICTION)
            self._law = self._new_law(reliable, pressed)
        else:
            self._law = self._new_law(FRICTION_SHARE * friction, CAUGHT_SHARE * pressed)

    def _new_law(self, friction: float, pressed: float) -> LoadGrip:
        return LoadGrip(friction, pressed, LAW)

    def _about_grip_point(self, wrench: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the load's wrench about the grip point, (6,)."""
        wrench = wrench - self._tare
        torque = wrench[3:] - np.cross(self._grip_point, wrench[:3])
        return np.concatenate([wrench[:3], torque])

    def _tangential(self, load: NDArray[np.float64], forces: NDArray[np.float64]) -> float:
        """Return the force along the pads that loads them as the force and the turning do, N."""
        force = float(np.hypot(load[1], load[2]))
        turning = abs(float(load[3])) / self._turning_radius(forces)
        return float(np.hypot(force, min(turning, MAX_TURNING * force)))

    def _turning_radius(self, forces: NDArray[np.float64]) -> float:
        """Return the mean distance from the closing axis at which the pads resist turning, m."""
        fingers = np.maximum(forces[: len(self._offsets)], 0.0)
        total = float(fingers.sum())
        if total <= 0.0:
            return PATCH_RADIUS
        middle = float(fingers @ self._offsets) / total
        arms = np.maximum(np.abs(self._offsets - middle), PATCH_RADIUS)
        # The thumb presses with the same force on one patch.
        return 0.5 * (float(fingers @ arms) / total + PATCH_RADIUS)

    def _drops(self, cell: Cell, carried: float, speed: float) -> bool:
        """Return whether the load falls below the weight of the accelerated object.

        A load that stays below it shows that the weight was measured too high, which is corrected.
        """
        period = cell.robot.period
        if self._speed is None:
            self._speed = speed
        # The derivative of the filtered speed lags as the filtered load does.
        acceleration = (speed - self._speed) / FILTER_SECONDS
        self._speed += (speed - self._speed) * (1.0 - np.exp(-period / FILTER_SECONDS))
        missing = self.weight * (1.0 + acceleration / GRAVITY) - carried
        dropped = missing > max(DROP_SHARE * self.weight, DROP_FORCE)
        dropped = dropped and self.pushed <= PUSH_FORCE
        self._drop = self._drop + period if dropped else 0.0
        if self._drop < DROP_SECONDS:
            return False
        self._drop = 0.0
        self.slips += 1
        self.weight -= 0.5 * missing
        return True


def mean_wrench(cell: Cell) -> NDArray[np.float64] | None:
    """Keep the arm still, and return the mean measurement of the wrist, (6,); None without one."""
    found: list[NDArray[np.float64]] = []

    def note(reading: RobotReading) -> None:
        wrench = measured_wrench(reading)
        if wrench is not None:
            found.append(wrench)

    if cell.reading.wrench is not None:
        cell.wait(MEAN_SECONDS, note)
    return np.mean(found, axis=0) if found else None


def measured_wrench(reading: RobotReading) -> NDArray[np.float64] | None:
    """Return the wrench of a reading, (6,); None if it is missing or not finite.

    Raises
    ------
    InputError
        If it has another shape.
    """
    wrench = reading.wrench
    if wrench is None:
        return None
    if np.shape(wrench) != (6,):
        raise InputError(f"RobotReading.wrench must have shape (6,), got {np.shape(wrench)}")
    return wrench if np.isfinite(wrench).all() else None

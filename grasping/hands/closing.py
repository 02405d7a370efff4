"""Close a compliant hand: gently until both sides touch, then firmly."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from ..prototypes import Prototype
from .grip_options import TENSION_PER_TIP_FORCE, GripOptions
from .hand_messages import AnyReading, DriveMode, HandCommand, HandReading
from .hand_model import HandModel
from .hand_names import PINCER_FINGER, THUMB, WRAP_DRIVES
from .hand_state import (
    MIN_ENCLOSED_WIDTH,
    finger_forces,
    finger_reading,
    grip_width,
    is_holding,
)
from .wrapping import DRAW_TENSION, DRAW_TENSION_RATE, THUMB_HOLD_SHARE, Wrapping

ClosingState = Literal["preshape", "closing", "gripping", "holding", "empty", "stalled"]
"""State of the closing hand.

- preshape: closing has not begun.
- closing: until both sides touch.
- gripping: the tension rises.
- holding: the grip is steady.
- empty: the hand closed without an object.
- stalled: the hand does not follow its command.
"""

IDLE_OPENING = 0.06
"""Additional opening of the idle fingers in a pincer grasp, m. They stay clear of the object, but
no farther out than neighbours allow."""
ROUND_ALLOWANCE = 0.024
"""Distance, doubled, by which a round object of 50 mm is thinner at the next finger than at the
middle one, m."""
OVERTRAVEL = 0.03
"""Distance by which the fingers follow an off-centre object beyond the closed position, m."""
MIN_GAP = 0.003
"""Width below which the hand has closed without an object, m."""
TOUCH_HOLD_TENSION = 25.0
"""Maximum tension of a finger that touches first and waits for the thumb, N."""
WRAP_HOLD_TENSION = 40.0
"""Maximum tension with which pre-bent outer joints keep their bend in a precision grasp, N. It
grows with the square of the tension above `GripOptions.finger_tension`."""
TENSION_RATE = 200.0
"""Rate at which the fingers' tension rises, N/s. Slower lets round objects settle."""
LOST_SECONDS = 0.15
"""Time without force on one side after which the hand is empty, s. A light object bounces between
the pads at first."""
STEADY_SPEED = 0.05
"""Joint speed below which the grip is steady, rad/s."""
STEADY_SECONDS = 0.06
"""Time for which the joint speed must stay below it, s."""
GRIP_SECONDS = 2.0
"""Maximum time of the rise of the tension, s. A grip that still moves then counts as holding."""
END_SECONDS = 0.3
"""Time at the end of their travel after which fingers without contact count as empty, s."""
MIN_TENSION = 4.0
"""Minimum tension of a finger that holds an object, N."""
CAGE_WIDTH, CAGE_SECONDS = 0.045, 0.35
"""Opening, m, and time, s, of the cage: fingertips that met in front of a slim object at the palm
open again and bend around it."""
CAGE_CHECK_PERIODS = 3.0
"""Number of cage times after which a caged object must be held. It has to be drawn in first."""


class Closing:
    """Controller that closes the hand on an object, one control period at a time.

    Each side closes gently until it touches, and then waits for the other side. So an off-centre
    object is not pushed over. Then the thumb holds its place and the fingers' tension rises. In a
    power grasp the outer joints bend as well: they draw the object to the palm, and the phalanges
    enclose it (`Wrapping`).

    Parameters
    ----------
    hand
        The hand.
    prototype
        Prototype of the grasp.
    opening
        Opening from which the hand closes, m.
    options
        Speed and tensions.

    Raises
    ------
    InputError
        If the prototype is unknown.
    """

    def __init__(
        self,
        hand: HandModel,
        prototype: Prototype,
        opening: float,
        options: GripOptions | None = None,
    ) -> None:
        if prototype not in get_args(Prototype):
            raise InputError(
                f"prototype must be one of {', '.join(get_args(Prototype))}, got {prototype!r}"
            )
        self._hand = hand
        self._prototype: Prototype = prototype
        self._options = options or GripOptions()
        self.state: ClosingState = "preshape"
        self.touched = False
        names = hand.drives
        self._thumb = names.index(THUMB)
        self._wraps = [k for k, name in enumerate(names) if name in WRAP_DRIVES]
        others = [k for k in range(len(names)) if k != self._thumb and k not in self._wraps]
        pincer = [k for k in others if names[k] == PINCER_FINGER]
        one_finger = prototype == "pincer" and bool(pincer)
        self._fingers = pincer if one_finger else others
        self._finger_count = 1 if one_finger else len(hand.fingers) - 1
        start = preshape_command(hand, opening, prototype)
        self._modes: list[DriveMode] = list(start.modes)
        self._values = start.values.copy()
        self._elapsed = self._steady_seconds = self._tension = self._lost_seconds = 0.0
        self._caged = False
        self._bend = 0.0
        self._slack = np.zeros(len(names))
        self._wrapping: Wrapping | None = None
        self._angles: NDArray[np.float64] | None = None
        # Beyond the closed hand, to follow an off-centre object.
        self._ends = hand.excursions[0] + hand.excursions[0] - hand.excursions_at(2.0 * OVERTRAVEL)

    @property
    def grip_tension(self) -> float:
        """Tension of each finger's tendon in the grip, N."""
        return self._options.finger_tension(self._prototype, self._finger_count)

    def step(self, reading: AnyReading, dt: float) -> HandCommand:
        """Compute the command for the next control period.

        Parameters
        ----------
        reading
            Readings of the hand.
        dt
            Control period, s.
        """
        reading = finger_reading(reading)
        if self.state == "preshape":
            self.state = "closing"
            moving = [*self._fingers, self._thumb]
            self._values[moving] = reading.excursions[moving]
        if self.state == "closing":
            self._close(reading, dt)
        elif self.state == "gripping":
            self._grip(reading, dt)
        elif self.state == "holding" and self._lost(reading, dt):
            self.state = "empty"
        self._angles = reading.angles
        return HandCommand(tuple(self._modes), self._values.copy())

    @property
    def tension(self) -> float:
        """Tension of each finger's tendon now, N."""
        return self._tension

    @property
    def tension_per_force(self) -> float:
        """Usual ratio of the tension of each finger to the force of all pads together."""
        return TENSION_PER_TIP_FORCE / (2.0 * self._finger_count)

    def pull_with(self, tension: float) -> None:
        """Hold the object with a tension of each finger, N, instead of `grip_tension`."""
        if self.state != "holding":
            return
        highest = max(self._options.max_tension, self.grip_tension)
        self._tension = float(np.clip(tension, MIN_TENSION, highest))
        raised = max(self._tension / self.grip_tension, 1.0)
        for k in self._fingers:
            if self._modes[k] == "pull":
                self._values[k] = self._tension
        if self._modes[self._thumb] == "hold":
            limit = THUMB_HOLD_SHARE * self._finger_count * self.grip_tension
            self._values[self._thumb] = raised * limit
        for k in self._wraps:
            # Otherwise the fingers straighten under the higher tension, and push the object out.
            if self._modes[k] == "hold":
                self._values[k] = WRAP_HOLD_TENSION * raised**2

    def ease(self, tension: float, thumb_tension: float) -> None:
        """Hold the object lightly with tensions of each finger and of the thumb, N.

        The thumb follows the object instead of keeping its place, until :meth:`end_ease`.
        """
        self.pull_with(tension)
        self._modes[self._thumb], self._values[self._thumb] = "pull", thumb_tension

    def end_ease(self) -> None:
        """Let the thumb keep its place again, as in the grip."""
        self._modes[self._thumb] = "hold"
        self.pull_with(self._tension)

    def _close(self, reading: HandReading, dt: float) -> None:
        options, hand = self._options, self._hand
        forces = finger_forces(reading, hand)
        thumb = forces[-1] >= options.touch_force
        touching = [self._force_of(k, forces) >= options.touch_force for k in self._fingers]
        for k, touch in zip([*self._fingers, self._thumb], [*touching, thumb], strict=True):
            if touch and self._modes[k] != "hold":
                self._modes[k] = "hold"
                self._values[k] = TOUCH_HOLD_TENSION
            elif self._modes[k] == "position":
                self._slack[k] = reading.tensions[k]
                self._values[k] = min(self._values[k] + options.closing_speed * dt, self._ends[k])
        width = grip_width(reading, hand)
        slim = self._prototype == "power" and width < MIN_ENCLOSED_WIDTH
        if slim or width < MIN_GAP:
            # The tips also meet in front of a slim object at the palm. Wrapping decides.
            self._caged = slim
            self.state = "gripping" if slim else "empty"
            return
        stopped = [self._modes[k] == "hold" for k in self._fingers]
        if any(stopped) and self._modes[self._thumb] == "hold":
            self.touched = True
            self.state = "gripping"
            # An impact may raise the tension above what the thumb can oppose.
            tension = float(np.mean([reading.tensions[k] for k in self._fingers]))
            self._tension = min(tension, self.grip_tension)
            return
        moving = [k for k in [*self._fingers, self._thumb] if self._modes[k] == "position"]
        if all(self._values[k] >= self._ends[k] for k in moving):
            self._elapsed += dt
            if self._elapsed > END_SECONDS:
                self.state = "empty"

    def _grip(self, reading: HandReading, dt: float) -> None:
        goal = self.grip_tension
        self._elapsed += dt
        if self._caged and self._elapsed < CAGE_SECONDS:
            self._cage(dt)
            return
        if self._angles is not None:
            speed = float(np.abs(reading.angles - self._angles).max(initial=0.0)) / dt
            self._steady_seconds = self._steady_seconds + dt if speed < STEADY_SPEED else 0.0
        limit, wrapped = goal, True
        if self._prototype == "power" and self._wraps:
            limit, wrapped = self._wrap(reading, dt)
        self._tension = min(self._tension + TENSION_RATE * dt, max(limit, self._tension))
        self._pull(reading, dt)
        check_after = CAGE_CHECK_PERIODS * CAGE_SECONDS if self._caged else 0.0
        firm = self._tension >= goal and self._elapsed > check_after
        if self._lost(reading, dt) and firm:
            self.state = "empty"
        elif self._elapsed > GRIP_SECONDS or (
            self._tension >= goal
            and wrapped
            and self._steady_seconds >= STEADY_SECONDS
            and self._lost_seconds == 0.0
        ):
            self.state = "holding"

    def _wrap(self, reading: HandReading, dt: float) -> tuple[float, bool]:
        """Return the tension limit of the fingers, N, and whether the object is enclosed."""
        if self._wrapping is None:
            self._wrapping = Wrapping(
                self._hand, self._options, self.grip_tension, self._slack, self._bend
            )
        steady = self._steady_seconds >= STEADY_SECONDS
        self._wrapping.step(reading, self._tension, steady, dt)
        return self._wrapping.limit, self._wrapping.stage == "wrapped"

    def _pull(self, reading: HandReading, dt: float) -> None:
        """Set the drives: fingers pull, the thumb opposes, outer joints bend or keep their bend."""
        forces, wrapping = finger_forces(reading, self._hand), self._wrapping
        for k in self._fingers:
            if self._modes[k] == "pull" or self._joins(k, forces):
                self._modes[k], self._values[k] = "pull", self._tension
            else:
                self._follow(k, reading, dt)
        for k in self._wraps:
            if wrapping is None:
                self._modes[k], self._values[k] = "hold", WRAP_HOLD_TENSION
            else:
                self._modes[k], self._values[k] = "pull", wrapping.bend(k)
        if wrapping is None:
            thumb = "hold", THUMB_HOLD_SHARE * self._finger_count * self.grip_tension
        else:
            thumb = wrapping.thumb(self._tension, self._fingers)
        self._modes[self._thumb], self._values[self._thumb] = thumb

    def _cage(self, dt: float) -> None:
        """Open tips that met in front of a slim object at the palm, and bend them around it."""
        for k in [*self._fingers, self._thumb]:
            self._modes[k], self._values[k] = "position", self._hand.excursions_at(CAGE_WIDTH)[k]
        self._bend = min(self._bend + DRAW_TENSION_RATE * dt, DRAW_TENSION)
        for k in self._wraps:
            self._modes[k], self._values[k] = "pull", self._bend

    def _joins(self, drive: int, forces: NDArray[np.float64]) -> bool:
        """Return whether a drive takes part in the grip.

        Beside a narrow object a finger without contact would close on nothing.
        """
        return (
            self._prototype == "power"
            or self._modes[drive] == "hold"
            or self._force_of(drive, forces) >= self._options.touch_force
        )

    def _follow(self, drive: int, reading: HandReading, dt: float) -> None:
        """Keep a finger without contact a little inside the others, for round objects."""
        width = grip_width(reading, self._hand) - ROUND_ALLOWANCE
        beside = self._hand.excursions_at(width)[drive]
        stride = self._options.closing_speed * dt
        self._values[drive] += float(np.clip(beside - self._values[drive], -stride, stride))

    def _lost(self, reading: HandReading, dt: float) -> bool:
        """Return whether nothing has been held for longer than a bounce."""
        self._lost_seconds = 0.0 if is_holding(reading, self._hand) else self._lost_seconds + dt
        return self._lost_seconds > LOST_SECONDS

    def _force_of(self, drive: int, forces: NDArray[np.float64]) -> float:
        """Return the maximum force on the fingers that a drive moves, N.

        A drive moves the finger of its name, or all fingers without a drive of the same name.
        """
        name, fingers = self._hand.drives[drive], self._hand.fingers[:-1]
        if name in fingers:
            return float(forces[fingers.index(name)])
        return max(
            (float(f) for f, n in zip(forces, fingers, strict=False) if n not in self._hand.drives),
            default=0.0,
        )


def preshape_command(hand: HandModel, opening: float, prototype: Prototype) -> HandCommand:
    """Return the command that opens the hand, m; idle fingers of a pincer open wider."""
    values = hand.excursions_at(opening)
    if prototype == "pincer" and PINCER_FINGER in hand.drives:
        for k, name in enumerate(hand.drives):
            if name not in (PINCER_FINGER, THUMB, *WRAP_DRIVES):
                values[k] = hand.excursions_at(opening + IDLE_OPENING)[k]
    return HandCommand(("position",) * len(hand.drives), values)


def open_command(hand: HandModel) -> HandCommand:
    """Return the command that opens the hand fully."""
    return HandCommand(("pull",) * len(hand.drives), np.zeros(len(hand.drives)))

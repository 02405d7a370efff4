"""Close a compliant hand: gently until both sides touch, then firmly, and wrap where it should."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from eyehand.errors import InputError

from .grip_options import GripOptions
from .hand_names import PINCER_FINGER, THUMB, WRAPS
from .hand_state import LEAST_WRAPPED, finger_forces, held, width
from .prototypes import Prototype
from .robot import HandCommand
from .wrapping import ANVIL, Wrapping

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hand_model import HandModel
    from .robot import DriveMode, HandReading

ClosingState = Literal["preshape", "closing", "gripping", "holding", "empty"]
"""preshape: not begun; closing: until both sides touch; gripping: the force rises; holding: it is
steady; empty: closed with nothing between."""

ASIDE = 0.06
"""How much wider than a pincer its other fingers stand, m: out of the way of what it pinches, and
no farther out than neighbours leave room for."""
FALLS_BACK = 0.024
"""Twice as far as a round thing of 50 mm falls back between the middle of the hand and the next
finger, m: whatever is rounder, that finger passes."""
BEYOND = 0.03
"""How far past the middle fingers follow an object that stands off it, m."""
CAGE_WIDTH, CAGE_SECONDS = 0.045, 0.35
"""Tips that met before a slim thing at the palm part so far, m, and bend for so long, s."""
CAGED = 3.0
"""After how many times that the hand around a slim thing is judged: it has to be drawn in."""


class Closing:
    """Closes the hand on whatever is between fingers and thumb, one control period at a time.

    Each side closes gently until it touches and then waits for the other, so that an object off
    the middle is met where it is and not pushed over. Then the thumb holds its place as an anvil
    and the fingers' force rises. In a power grasp the outer joints are bent as well: what the
    tips hold is drawn to the palm, and the phalanges close around it.

    Parameters
    ----------
    hand
        The hand.
    prototype
        How to grip.
    opening
        Free width from which the hand closes, m.
    options
        Speeds and tensions.
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
        self._wraps = [k for k, name in enumerate(names) if name in WRAPS]
        rest = [k for k in range(len(names)) if k != self._thumb and k not in self._wraps]
        only = [k for k in rest if names[k] == PINCER_FINGER]
        alone = prototype == "pincer" and bool(only)
        self._fingers = only if alone else rest
        self._pulling = 1 if alone else len(hand.fingers) - 1
        start = preshape_command(hand, opening, prototype)
        self._modes: list[DriveMode] = list(start.modes)
        self._values = start.values.copy()
        self._begun = self._steady = self._level = self._loose = 0.0
        self._caged = False
        self._bend = 0.0
        self._slack = np.zeros(len(names))
        self._wrapping: Wrapping | None = None
        self._angles: NDArray[np.float64] | None = None
        # Past the closed hand, as far as an object off the middle may stand.
        self._ends = hand.excursions[0] + hand.excursions[0] - hand.pulled(2.0 * BEYOND)

    @property
    def grip_force(self) -> float:
        """Tension of each finger's tendon when gripped, N."""
        return self._options.grip(self._prototype, self._pulling)

    def step(self, reading: HandReading, dt: float) -> HandCommand:
        """Give the command for the next control period.

        Parameters
        ----------
        reading
            What the hand feels now.
        dt
            The period, s.
        """
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

    def _close(self, reading: HandReading, dt: float) -> None:
        options, hand = self._options, self._hand
        forces = finger_forces(reading, hand)
        thumb = forces[-1] >= options.touch_force
        touching = [self._force_of(k, forces) >= options.touch_force for k in self._fingers]
        for k, touch in zip([*self._fingers, self._thumb], [*touching, thumb], strict=True):
            if touch and self._modes[k] != "hold":
                self._modes[k] = "hold"
                self._values[k] = options.touch_hold
            elif self._modes[k] == "place":
                self._slack[k] = reading.tensions[k]
                self._values[k] = min(self._values[k] + options.closing_speed * dt, self._ends[k])
        slim = self._prototype == "power" and width(reading, hand) < LEAST_WRAPPED
        if slim or width(reading, hand) < options.least_gap:
            # Before a slim thing at the palm the tips meet too: only wrapping tells.
            self._caged = slim
            self.state = "gripping" if slim else "empty"
            return
        stopped = [self._modes[k] == "hold" for k in self._fingers]
        if any(stopped) and self._modes[self._thumb] == "hold":
            self.touched = True
            self.state = "gripping"
            # What a finger runs into pulls more for a moment than the thumb is set to oppose.
            pulled = float(np.mean([reading.tensions[k] for k in self._fingers]))
            self._level = min(pulled, self.grip_force)
            return
        moving = [k for k in [*self._fingers, self._thumb] if self._modes[k] == "place"]
        if all(self._values[k] >= self._ends[k] for k in moving):
            self._begun += dt
            if self._begun > 0.3:
                self.state = "empty"

    def _grip(self, reading: HandReading, dt: float) -> None:
        options, goal = self._options, self.grip_force
        self._begun += dt
        if self._caged and self._begun < CAGE_SECONDS:
            self._cage(dt)
            return
        if self._angles is not None:
            speed = float(np.abs(reading.angles - self._angles).max(initial=0.0)) / dt
            self._steady = self._steady + dt if speed < options.settled_speed else 0.0
        limit, wrapped = goal, True
        if self._prototype == "power" and self._wraps:
            limit, wrapped = self._wrap(reading, dt)
        self._level = min(self._level + options.ramp * dt, max(limit, self._level))
        self._pull(reading, dt)
        firm = self._level >= goal and self._begun > (CAGED * CAGE_SECONDS if self._caged else 0.0)
        if self._lost(reading, dt) and firm:
            self.state = "empty"
        elif self._begun > options.grip_seconds or (
            self._level >= goal
            and wrapped
            and self._steady >= options.settle_seconds
            and self._loose == 0.0
        ):
            self.state = "holding"

    def _wrap(self, reading: HandReading, dt: float) -> tuple[float, bool]:
        """Give the fingers' tension for now, N, and whether the object is wrapped."""
        if self._wrapping is None:
            self._wrapping = Wrapping(
                self._hand, self._options, self.grip_force, self._slack, self._bend
            )
        steady = self._steady >= self._options.settle_seconds
        self._wrapping.step(reading, self._level, steady, dt)
        return self._wrapping.limit, self._wrapping.stage == "wrapped"

    def _pull(self, reading: HandReading, dt: float) -> None:
        """Set the drives: fingers pull, the thumb opposes, outer joints bend or keep their bend."""
        forces, wrapping = finger_forces(reading, self._hand), self._wrapping
        for k in self._fingers:
            if self._modes[k] == "pull" or self._joins(k, forces):
                self._modes[k], self._values[k] = "pull", self._level
            else:
                self._accompany(k, reading, dt)
        for k in self._wraps:
            if wrapping is None:
                self._modes[k], self._values[k] = "hold", self._options.wrap_hold
            else:
                self._modes[k], self._values[k] = "pull", wrapping.bend(k)
        if wrapping is None:
            thumb = "hold", ANVIL * self._pulling * self.grip_force
        else:
            thumb = wrapping.thumb(self._level, self._fingers)
        self._modes[self._thumb], self._values[self._thumb] = thumb

    def _cage(self, dt: float) -> None:
        """Part tips that met before a slim thing at the palm, and bend them around it."""
        options = self._options
        for k in [*self._fingers, self._thumb]:
            self._modes[k], self._values[k] = "place", self._hand.pulled(CAGE_WIDTH)[k]
        self._bend = min(self._bend + options.draw_ramp * dt, options.draw_tension)
        for k in self._wraps:
            self._modes[k], self._values[k] = "pull", self._bend

    def _joins(self, drive: int, forces: NDArray[np.float64]) -> bool:
        """Whether a drive's fingers press something: beside a narrow object they would close on."""
        return (
            self._prototype == "power"
            or self._modes[drive] == "hold"
            or self._force_of(drive, forces) >= self._options.touch_force
        )

    def _accompany(self, drive: int, reading: HandReading, dt: float) -> None:
        """Keep fingers that touch nothing a little before the others: round things fall back."""
        beside = self._hand.pulled(width(reading, self._hand) - FALLS_BACK)[drive]
        stride = self._options.closing_speed * dt
        self._values[drive] += float(np.clip(beside - self._values[drive], -stride, stride))

    def _lost(self, reading: HandReading, dt: float) -> bool:
        """Whether nothing has been held for longer than a bounce."""
        self._loose = 0.0 if held(reading, self._hand) else self._loose + dt
        return self._loose > self._options.lost_seconds

    def _force_of(self, drive: int, forces: NDArray[np.float64]) -> float:
        """Largest force on a finger that a drive moves: its own name, or every other finger."""
        name, fingers = self._hand.drives[drive], self._hand.fingers[:-1]
        if name in fingers:
            return float(forces[fingers.index(name)])
        return max(
            (float(f) for f, n in zip(forces, fingers, strict=False) if n not in self._hand.drives),
            default=0.0,
        )


def preshape_command(hand: HandModel, opening: float, prototype: Prototype) -> HandCommand:
    """Open the hand to a free width, in m; a pincer's other fingers stay out of the way."""
    values = hand.pulled(opening)
    if prototype == "pincer" and PINCER_FINGER in hand.drives:
        for k, name in enumerate(hand.drives):
            if name not in (PINCER_FINGER, THUMB, *WRAPS):
                values[k] = hand.pulled(opening + ASIDE)[k]
    return HandCommand(("place",) * len(hand.drives), values)


def open_command(hand: HandModel) -> HandCommand:
    """Open the hand as far as it goes."""
    return HandCommand(("pull",) * len(hand.drives), np.zeros(len(hand.drives)))

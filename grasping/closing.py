"""Close a compliant hand: gently until both sides touch, then firmly, and wrap where it should."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from eyehand.errors import InputError

from .hand_names import PALM, PINCER_FINGER, THUMB, TIP, WRAPS
from .prototypes import Prototype
from .robot import HandCommand

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .hand_model import HandModel
    from .robot import DriveMode, HandReading

ClosingState = Literal["preshape", "closing", "gripping", "holding", "empty"]
"""preshape: not begun; closing: until both sides touch; gripping: the force rises; holding: it is
steady; empty: closed with nothing between."""

ANVIL = 1.4
"""The thumb holds its place up to this share of what all fingers pull: it opposes them all."""
TIP_LEVER = 15.0
"""Tension over force at the fingertip, as measured: 90 mm of finger on a knuckle's arm of 12 mm,
less what springs and the outer joints take."""
CLOSED_WIDTH = 0.002
CLOSED_BEND = 1.0
"""Where only tips feel force, a hand closed on itself shows by its width, m; one whose middle
finger is bent more than this, rad, is wrapped, and closes on itself sooner."""
CROSSED_WIDTH = -0.005
"""Straight fingers past this width, m, have gone through where anything could be, and press on the
thumb's inner phalanx."""
LEAST_WRAPPED = 0.015
"""Nothing that a power grasp is meant for is slimmer, m: there the tips meet before they touch."""
OWN_PALM_CURL = 2.4
"""A finger curled further, rad, that feels at its tip alone has it on the own palm: 2.8 empty, 1.6
around 60 mm; longer fingers curl as far around what their inner phalanges feel. Such is most of a
hand closed on nothing, or one finger while the thumb feels nothing."""
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
GRAVITY = 9.81
"""m/s²."""


@dataclass(frozen=True)
class GripOptions:
    """Speeds and tensions of closing.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    closing_speed: float = 0.014
    """Of a finger's tendon until touch, m/s: 0.1 m/s at the tips. Slower pushes light things
    less."""
    touch_force: float = 0.3
    """Force on a side's pads that counts as touch, N: lower topples less, and trips on noise."""
    touch_hold: float = 25.0
    """Largest tension with which a finger that touches first waits for the thumb, N."""
    tension: dict[Prototype, float] = field(
        default_factory=lambda: {"pincer": 45.0, "precision": 70.0, "power": 90.0}
    )
    """Tension of each finger's tendon in the grip, N."""
    wrap_tension: float = 60.0
    """Tension of the tendon that bends the outer joints in a power grasp, N."""
    thumb_wrap_tension: float = 90.0
    """The same of the thumb's, which is alone against three."""
    wrap_ramp: float = 150.0
    """How fast the wrapping tendons' tension rises, N/s."""
    wrap_hold: float = 40.0
    """Largest tension with which a pre-bent finger keeps its bend in a precision grasp, N."""
    wrap_share: float = 0.2
    """Share of the power grip's tension from which the outer joints are bent: earlier draws the
    object to the palm with less friction, later has it held more surely meanwhile."""
    draw_seconds: float = 0.4
    """How long a power grasp pulls with less force than its own, to draw the object to the palm."""
    ramp: float = 200.0
    """How fast the fingers' tension rises, N/s: slower lets round things settle."""
    load: float | None = None
    """Mass to lift, kg, if known: light things get less force; None grips with the whole."""
    friction: float = 0.6
    """Friction assumed for that load."""
    safety: float = 3.0
    """Grip force over what that load needs."""
    least_share: float = 0.5
    """Least share of the prototype's tension, however light the load."""
    least_gap: float = 0.003
    """Free width below which the hand is closed on nothing, m."""
    lost_seconds: float = 0.15
    """How long nothing is felt on one side before the hand counts as empty: a light object bounces
    between the pads at first."""
    settled_speed: float = 0.05
    """Joint speed below which the grip is steady, rad/s."""
    settle_seconds: float = 0.06
    """How long it must be so."""
    grip_seconds: float = 2.0
    """Longest rise of the force; a grip still moving then counts as holding."""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, float) and not 0.0 < value < 1e4:
                raise InputError(f"grip option {name} must lie in (0, 10000), got {value}")
        for prototype, value in self.tension.items():
            if prototype not in get_args(Prototype) or not 0.0 < value < 1e4:
                raise InputError(f"tension {prototype!r} must be > 0 N, got {value}")

    def grip(self, prototype: Prototype, fingers: int) -> float:
        """Tension of each finger in the grip, N, scaled to the load where that is known."""
        most = self.tension[prototype]
        if self.load is None:
            return most
        needed = self.load * GRAVITY * self.safety / (2.0 * self.friction)
        return float(np.clip(needed / fingers * TIP_LEVER, self.least_share * most, most))


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
        self._drawn = prototype != "power"
        self._wrap_level = np.zeros(len(names))
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
        limit = goal if self._drawn else options.wrap_share * goal
        self._level = min(self._level + options.ramp * dt, max(limit, self._level))
        forces = finger_forces(reading, self._hand)
        for k in self._fingers:
            if self._modes[k] == "pull" or self._joins(k, forces):
                self._modes[k], self._values[k] = "pull", self._level
            else:
                self._accompany(k, reading, dt)
        self._modes[self._thumb] = "hold"
        self._values[self._thumb] = ANVIL * self._pulling * goal
        wrapped = self._wrap(dt)
        if self._angles is not None:
            speed = float(np.abs(reading.angles - self._angles).max(initial=0.0)) / dt
            self._steady = self._steady + dt if speed < options.settled_speed else 0.0
        self._drawn = self._drawn or (
            wrapped
            and (self._steady >= options.settle_seconds or self._begun > options.draw_seconds)
        )
        firm = self._level >= limit and self._begun > (CAGE_SECONDS * 3.0 if self._caged else 0.0)
        if self._lost(reading, dt) and firm:
            self.state = "empty"
        elif self._begun > options.grip_seconds or (
            self._level >= goal
            and wrapped
            and self._steady >= options.settle_seconds
            and self._loose == 0.0
        ):
            self.state = "holding"

    def _cage(self, dt: float) -> None:
        """Part tips that met before a slim thing at the palm, and bend them around it."""
        for k in [*self._fingers, self._thumb]:
            self._modes[k], self._values[k] = "place", self._hand.pulled(CAGE_WIDTH)[k]
        for k in self._wraps:
            self._wrap_level[k] = min(
                self._wrap_level[k] + self._options.wrap_ramp * dt, self._options.wrap_tension
            )
            self._modes[k], self._values[k] = "pull", self._wrap_level[k]

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

    def _wrap(self, dt: float) -> bool:
        """Bend the outer joints of a power grasp, keep their bend in others; tell when done."""
        options = self._options
        if self._prototype != "power":
            for k in self._wraps:
                self._modes[k], self._values[k] = "hold", options.wrap_hold
            return True
        if self._level < options.wrap_share * self.grip_force:
            return False
        done = True
        for k in self._wraps:
            thumb = self._hand.drives[k].startswith(THUMB)
            goal = options.thumb_wrap_tension if thumb else options.wrap_tension
            goal *= self.grip_force / options.tension["power"]
            self._wrap_level[k] = min(self._wrap_level[k] + options.wrap_ramp * dt, goal)
            self._modes[k], self._values[k] = "pull", self._wrap_level[k]
            done = done and self._wrap_level[k] >= goal
        return done

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


def curl(reading: HandReading, hand: HandModel) -> float:
    """How far the fingers bend around: the sum of a finger's outer joints, their mean, rad.

    The thumb does not count: it opposes.
    """
    return float(np.mean([_bend(reading, hand, finger) for finger in hand.fingers[:-1]]))


def width(reading: HandReading, hand: HandModel) -> float:
    """Free width between the middle finger's pad and the thumb's by the tendons' excursions, m.

    True to some mm as long as the outer joints are not bent by contact; below 0 beyond closed.
    """
    halves = {
        name: _half(hand, k, reading.excursions[k])
        for k, name in enumerate(hand.drives)
        if name not in WRAPS
    }
    thumb = halves.pop(THUMB)
    finger = halves.get(PINCER_FINGER, max(halves.values()))
    return finger + thumb


def held(reading: HandReading, hand: HandModel, least: float = 0.2) -> bool:
    """Whether something is between the fingers and thumb or palm: both sides feel force, in N.

    A hand closed on itself feels force too; that shows in its joints.
    """
    forces = finger_forces(reading, hand)
    against = forces[-1] + _inner_force(reading, hand, PALM)
    if forces[:-1].max() < least or against < least:
        return False
    palm, inner = _inner_force(reading, hand, PALM), _inner_force(reading, hand, "")
    fingers = hand.fingers[:-1]
    on_palm = {
        one
        for one in fingers
        if _curled(reading, hand, one) > OWN_PALM_CURL and _inner_force(reading, hand, one) < least
    }
    if 2 * len(on_palm) > len(fingers):
        return False
    if inner - palm < least and forces[-1] < least and PINCER_FINGER in on_palm:
        return False
    bent = _bend(reading, hand, PINCER_FINGER) > CLOSED_BEND
    if inner >= least:
        return bent or width(reading, hand) > CROSSED_WIDTH
    return width(reading, hand) > (LEAST_WRAPPED if bent else CLOSED_WIDTH)


def finger_forces(reading: HandReading, hand: HandModel) -> NDArray[np.float64]:
    """Force on each finger, the thumb last, N."""
    return np.array(
        [
            sum(f for f, pad in zip(reading.forces, hand.pads, strict=True) if pad.startswith(name))
            for name in hand.fingers
        ]
    )


def _bend(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Sum of a finger's joints past the first, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints[1:]].sum())


def _curled(reading: HandReading, hand: HandModel, finger: str) -> float:
    """Sum of all joints of a finger, rad."""
    joints = [k for k, name in enumerate(hand.joints) if name.startswith(finger)]
    return float(reading.angles[joints].sum())


def _inner_force(reading: HandReading, hand: HandModel, name: str) -> float:
    """Force on pads that do not meet one another when the hand closes on nothing, N."""
    pads = zip(reading.forces, hand.pads, strict=True)
    return float(sum(f for f, pad in pads if pad.startswith(name) and not pad.endswith(TIP)))


def _half(hand: HandModel, drive: int, excursion: float) -> float:
    """Half the width that an excursion makes, extended straight on beyond the closed hand."""
    pulled, halves = hand.excursions[::-1, drive], hand.openings[::-1] / 2
    if excursion > pulled[-1]:
        slope = (halves[-1] - halves[-4]) / (pulled[-1] - pulled[-4])
        return float(halves[-1] + slope * (excursion - pulled[-1]))
    return float(np.interp(excursion, pulled, halves))

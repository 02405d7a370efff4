"""How the tensions of a power grasp rise, so that every phalanx comes to lie on the object.

Without friction the forces of a finger's phalanges follow from the torques of its joints alone
(Birglen, Laliberté and Gosselin, Underactuated Robotic Hands, 2008, ch. 3). Around a cylinder at
the palm the tendon of the whole finger presses with every phalanx; bending the outer joints besides
lifts the middle one off. So they are bent only to draw an object to the palm, with the fingers
slack, and let go while the fingers tighten: knuckle first, tip last, so that nothing has to slide
under force to its place. What the palm cannot reach is hooked: the outer joints stay bent, for
tightened fingers would press it out along the proximal phalanges, which lean apart there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from .hand_state import THUMB, inner_force

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .grip_options import GripOptions
    from .hand_model import HandModel
    from .robot import HandReading

ANVIL = 1.4
"""The thumb holds its place up to this share of what all fingers pull: it opposes them all."""
THUMB_DRAW = 1.0
"""Tension that bends the thumb's outer joint, over that of the fingers'."""
LEAST_DRAW = 0.15
"""An object that touches the palm is drawn on for so long, s: it bounces."""

Stage = Literal["draw", "tighten", "wrapped"]
"""draw: to the palm; tighten: the fingers' tension rises; wrapped: it is all there."""


class Wrapping:
    """Tensions of a power grasp, one control period at a time, after both sides have touched.

    Parameters
    ----------
    hand
        The hand; it has tendons that bend the outer joints.
    options
        Tensions and speeds.
    goal
        Tension of each finger's tendon in the grip, N.
    slack
        Tension of each drive with which it moved without touching anything, (D,), N.
    bent
        Tension with which the outer joints are bent already, N.
    """

    def __init__(
        self,
        hand: HandModel,
        options: GripOptions,
        goal: float,
        slack: NDArray[np.float64],
        bent: float = 0.0,
    ) -> None:
        self._hand, self._options, self._goal = hand, options, goal
        self._slack = slack
        self._bend = bent
        self._seconds = 0.0
        self._reached = False
        self.stage: Stage | None = None

    @property
    def limit(self) -> float:
        """Tension to which a finger's tendon rises now, N."""
        return self._goal * (self._options.draw_share if self.stage == "draw" else 1.0)

    def step(self, reading: HandReading, level: float, steady: bool, dt: float) -> None:
        """Go on for a control period.

        Parameters
        ----------
        reading
            What the hand feels.
        level
            Tension of each finger's tendon now, N.
        steady
            Whether the joints have come to rest.
        dt
            The period, s.
        """
        options = self._options
        palm = inner_force(reading, self._hand, "palm") >= options.touch_force
        if self.stage is None:
            self.stage = "tighten" if palm and self._bend == 0.0 else "draw"
        self._seconds += dt
        drawn = palm and steady and self._seconds >= LEAST_DRAW
        if self.stage == "draw" and (drawn or self._seconds > options.draw_seconds):
            self.stage = "tighten"
        self._reached = self._reached or palm
        bend = options.draw_tension * self._goal / options.tension["power"]
        if self._reached and self.stage != "draw":
            bend = 0.0
        stride = options.draw_ramp * dt
        self._bend += float(np.clip(bend - self._bend, -stride, stride))
        if self.stage == "tighten" and level >= self._goal and self._bend == bend:
            self.stage = "wrapped"

    def bend(self, drive: int) -> float:
        """Tension of a tendon that bends outer joints, N."""
        return self._bend * (THUMB_DRAW if self._hand.drives[drive].startswith(THUMB) else 1.0)

    def thumb(self, level: float, fingers: list[int]) -> tuple[Literal["pull", "hold"], float]:
        """Mode and tension of the thumb.

        While the fingers tighten around what the palm feels, it pulls as they do together, past
        what springs take, so that its own phalanges come to lie as well; before, at last, and where
        the palm feels nothing, it is their anvil.
        """
        count = len(self._hand.fingers) - 1
        if self.stage != "tighten" or not self._reached:
            return "hold", ANVIL * count * self._goal
        own = self._slack[self._hand.drives.index(THUMB)]
        return "pull", max(own + count * (level - float(self._slack[fingers].mean())), 0.0)

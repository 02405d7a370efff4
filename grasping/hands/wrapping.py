"""Tension schedule of a power grasp, so that every phalanx comes to rest on the object.

Without friction, the forces of a finger's phalanges follow from its joint torques alone (Birglen,
Laliberté and Gosselin, Underactuated Robotic Hands, 2008, ch. 3). Around a cylinder at the palm,
the tendon of the whole finger presses with every phalanx. Bending the outer joints as well lifts
the middle phalanx off. Therefore the outer joints bend only to draw the object to the palm, while
the fingers are slack. They relax while the fingers tighten, from the knuckle to the tip, so that no
phalanx slides under force.

If the palm does not reach the object, the outer joints stay bent and hook it. Tight fingers would
push it out along the proximal phalanges, which diverge there.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .grip_options import GripOptions
from .hand_messages import HandReading
from .hand_model import HandModel
from .hand_names import PALM, THUMB
from .hand_state import non_tip_force

THUMB_HOLD_SHARE = 1.4
"""Maximum tension of the thumb while it holds its place, as a share of the tension of all fingers,
which it opposes."""
DRAW_TENSION = 60.0
"""Tension that bends the outer joints to draw the object to the palm, N. Higher draws heavier
objects, but bends the tips beyond the surface that they should touch."""
DRAW_TENSION_RATE = 300.0
"""Rate at which that tension rises and falls, N/s."""
THUMB_DRAW_SHARE = 1.0
"""Tension that bends the thumb's outer joint, as a share of that of the fingers."""
DRAW_GRIP_SHARE = 0.2
"""Share of the grip tension of the fingers while they draw. Less lets the object slide to the palm,
more holds it more firmly."""
MIN_DRAW_SECONDS = 0.15
"""Minimum time of drawing, s, even if the palm feels the object, because it bounces."""
MAX_DRAW_SECONDS = 0.5
"""Maximum time of drawing, s."""

Stage = Literal["draw", "tighten", "wrapped"]
"""Stage of a power grasp: draw to the palm, tighten the fingers, enclosed."""


class Wrapping:
    """Tensions of a power grasp after both sides have touched, one control period at a time.

    Parameters
    ----------
    hand
        A hand with drives that bend the outer joints.
    options
        Touch threshold and tensions.
    goal
        Tension of each finger's tendon in the grip, N.
    slack
        Tension of each drive while it moved without contact, (D,), N.
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
        self._palm_touched = False
        self.stage: Stage | None = None

    @property
    def limit(self) -> float:
        """Current limit of the tension of a finger's tendon, N."""
        return self._goal * (DRAW_GRIP_SHARE if self.stage == "draw" else 1.0)

    def step(self, reading: HandReading, level: float, steady: bool, dt: float) -> None:
        """Update stage and tensions for the next control period.

        Parameters
        ----------
        reading
            Readings of the hand.
        level
            Current tension of each finger's tendon, N.
        steady
            Whether the joints are at rest.
        dt
            Control period, s.
        """
        options = self._options
        palm = non_tip_force(reading, self._hand, PALM) >= options.touch_force
        if self.stage is None:
            self.stage = "tighten" if palm and self._bend == 0.0 else "draw"
        self._seconds += dt
        drawn = palm and steady and self._seconds >= MIN_DRAW_SECONDS
        if self.stage == "draw" and (drawn or self._seconds > MAX_DRAW_SECONDS):
            self.stage = "tighten"
        self._palm_touched = self._palm_touched or palm
        bend = DRAW_TENSION * self._goal / options.tension["power"]
        if self._palm_touched and self.stage != "draw":
            bend = 0.0
        stride = DRAW_TENSION_RATE * dt
        self._bend += float(np.clip(bend - self._bend, -stride, stride))
        if self.stage == "tighten" and level >= self._goal and self._bend == bend:
            self.stage = "wrapped"

    def bend(self, drive: int) -> float:
        """Return the tension of a drive that bends outer joints, N."""
        return self._bend * (
            THUMB_DRAW_SHARE if self._hand.drives[drive].startswith(THUMB) else 1.0
        )

    def thumb(self, level: float, fingers: list[int]) -> tuple[Literal["pull", "hold"], float]:
        """Return mode and tension, N, of the thumb.

        While the fingers tighten around an object at the palm, the thumb pulls with their total
        tension plus that of its springs. So its own phalanges come to rest on the object as well.
        Otherwise it holds its place against the fingers.
        """
        count = len(self._hand.fingers) - 1
        if self.stage != "tighten" or not self._palm_touched:
            return "hold", THUMB_HOLD_SHARE * count * self._goal
        own = self._slack[self._hand.drives.index(THUMB)]
        return "pull", max(own + count * (level - float(self._slack[fingers].mean())), 0.0)

"""Close two jaws on an object by width alone, or by width and effort."""

from __future__ import annotations

import numpy as np

from .closing import ClosingState
from .grip_options import GRAVITY, GripOptions
from .hand_messages import AnyReading, JawCommand, JawReading
from .parallel_hand import ParallelHand

EMPTY_WIDTH = 0.002
"""Width above the minimum opening up to which a closed gripper is empty, m. Encoders of grippers
are accurate to 1 mm."""
STILL_WIDTH = 0.0005
"""Change of the width below which the jaws stand still, m."""
STILL_SECONDS = 0.12
"""Time for which the width must stand still, s. It is longer than the delay of a network."""
STALL_SECONDS = 1.5
"""Time without motion and without effort after which the gripper does not follow, s. Grippers at a
serial line start up to 1.2 s late."""
GRIP_SECONDS = 0.25
"""Time in which the force rises to that of the grip, s."""
MIN_FORCE = 20.0
"""Force of each jaw however light the load seems, N. Its mass is an estimate."""
PAD_RADIUS_SHARE = 0.4
"""Radius at which a pad resists turning, as a share of the pad's smaller side."""
CONTACT_FORCE_SHARE = 0.5
"""Share of the grip force with which the jaws close until they touch."""
EFFORT_SHARE = 0.3
"""Minimum share of the commanded force that the motor measures in contact."""


class JawClosing:
    """Controller that closes two jaws: gently until the width stands still, then firmly.

    Parameters
    ----------
    hand
        The gripper.
    options
        Load, friction and safety, which determine the force of the grip.
    """

    def __init__(self, hand: ParallelHand, options: GripOptions) -> None:
        self._hand = hand
        self.state: ClosingState = "preshape"
        self.touched = False
        self.force = grip_force(hand, options)
        """Force of each jaw in the grip, N."""
        self._start = self._width = np.inf
        self._still = self._elapsed = 0.0

    def step(self, reading: AnyReading, dt: float) -> JawCommand:
        """Compute the command of the next control period of dt seconds."""
        assert isinstance(reading, JawReading), "the control of jaws checks its readings"
        if self.state == "preshape":
            self.state, self._start = "closing", reading.width
        self._elapsed += dt
        if abs(reading.width - self._width) > STILL_WIDTH:
            self._width, self._still = reading.width, 0.0
        else:
            self._still += dt
        empty = reading.width <= empty_width(self._hand)
        force = self.force
        if self.state == "closing":
            force = max(self._hand.force[0], CONTACT_FORCE_SHARE * self.force)
            self._close(reading, force, empty=empty)
        elif self.state == "gripping" and self._elapsed > GRIP_SECONDS:
            if empty:
                self.state = "empty"
            elif self._still > STILL_SECONDS:
                self.state = "holding"
        elif self.state == "holding" and empty:
            self.state = "empty"
        return JawCommand(self._hand.min_opening, force)

    def _close(self, reading: JawReading, force: float, *, empty: bool) -> None:
        if empty:
            self.state = "empty"
            return
        if self._still < STILL_SECONDS:
            return
        if reading.effort is None:
            # Without effort, jaws that never moved cannot have touched anything.
            contact = self._start - reading.width > STILL_WIDTH
        else:
            contact = reading.effort >= EFFORT_SHARE * force
        if contact:
            self.state, self.touched, self._elapsed = "gripping", True, 0.0
        elif self._still > STALL_SECONDS:
            self.state = "stalled"


def grip_force(hand: ParallelHand, options: GripOptions) -> float:
    """Return the force of each jaw that holds the load, within the gripper's range, N."""
    low, high = hand.force
    if options.load is None:
        return high
    radius = PAD_RADIUS_SHARE * min(hand.pad_width, hand.pad_height)
    turning = 1.0 + options.lever / radius
    needed = turning * options.load * GRAVITY * options.safety / (2.0 * options.friction)
    return float(np.clip(max(needed, MIN_FORCE), low, high))


def empty_width(hand: ParallelHand) -> float:
    """Return the width up to which the closed gripper is empty, m."""
    return hand.min_opening + EMPTY_WIDTH

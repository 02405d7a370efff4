"""Close two jaws on an object by width alone, or by width and effort."""

from __future__ import annotations

from collections import deque

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
MEAN_NOISE, MAX_READINGS = 0.0001, 40
"""Noise of the mean width, m, and the maximum number of readings of which it is taken. One reading
is enough without noise. Single readings with a noise of 0.5 mm never stand still."""
MOVED_NOISES = 3.0
"""Multiple of the noise that a motion must exceed in addition."""
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
        self._start = np.inf
        self._elapsed = 0.0
        self._motion = WidthMotion()

    def step(self, reading: AnyReading, dt: float) -> JawCommand:
        """Compute the command of the next control period of dt seconds."""
        assert isinstance(reading, JawReading), "the control of jaws checks its readings"
        if self.state == "preshape":
            self.state, self._start = "closing", reading.width
        self._elapsed += dt
        self._motion.step(reading.width, dt)
        empty = reading.width <= empty_width(self._hand)
        force = self.force
        if self.state == "closing":
            force = max(self._hand.force[0], CONTACT_FORCE_SHARE * self.force)
            self._close(reading, force, empty=empty)
        elif self.state == "gripping" and self._elapsed > GRIP_SECONDS:
            if empty:
                self.state = "empty"
            elif self._motion.still > STILL_SECONDS:
                self.state = "holding"
        elif self.state == "holding" and empty:
            self.state = "empty"
        return JawCommand(self._hand.min_opening, force)

    def _close(self, reading: JawReading, force: float, *, empty: bool) -> None:
        if empty:
            self.state = "empty"
            return
        motion = self._motion
        if motion.still < STILL_SECONDS:
            return
        # Jaws that never moved cannot have touched anything, or their width is not measured.
        moved = self._start - motion.width > STILL_WIDTH + MOVED_NOISES * motion.noise
        if moved and (reading.effort is None or reading.effort >= EFFORT_SHARE * force):
            self.state, self.touched, self._elapsed = "gripping", True, 0.0
        elif motion.still > STALL_SECONDS:
            self.state = "stalled"


class WidthMotion:
    """Detector of jaws that stand still, in spite of the noise of their width."""

    def __init__(self) -> None:
        self._widths: deque[float] = deque(maxlen=MAX_READINGS)
        self.width = np.inf
        """Width at which the jaws stand still, m."""
        self.noise = 0.0
        """Standard deviation of the readings without their motion, m."""
        self.still = 0.0
        """Time for which the jaws have stood still, s."""

    def step(self, width: float, dt: float) -> None:
        """Add a reading of the width, m, after a control period of dt seconds."""
        self._widths.append(width)
        widths = np.array(self._widths)
        if len(widths) > 2:
            # Second differences remove a constant speed, and their median removes its changes.
            bend = float(np.median(np.abs(np.diff(widths, n=2))))
            self.noise = bend / (_NORMAL_MEDIAN * 6.0**0.5)
        count = int(np.ceil(min(MAX_READINGS, (self.noise / MEAN_NOISE) ** 2)))
        mean = float(widths[-max(count, 1) :].mean())
        if abs(mean - self.width) > STILL_WIDTH:
            self.width, self.still = mean, 0.0
        else:
            self.still += dt


_NORMAL_MEDIAN = 0.6745
"""Median of the absolute values of a normal distribution with the standard deviation 1."""


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

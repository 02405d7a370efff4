"""Detection of a pressure that oscillates and does not settle."""

from __future__ import annotations

MIN_SWING = 0.5
"""Smallest swing that counts, from one turning point to the next, as a share of the goal. Noise
turns often, but with small swings."""
MAX_SWINGS = 5
"""Number of successive swings without decay that is an oscillation."""
MAX_SWING_SECONDS = 0.5
"""Longest time of one swing, s. Slower changes come from the object."""
DECAY = 0.9
"""A swing below this share of the one before decays. The loop then settles within a second."""


class OscillationDetector:
    """Detect large swings of the pressure that do not decay.

    The pressure also swings after contact, but each swing is smaller than the one before. What
    remains is a loop that is unstable or close to it.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Clear all swings."""
        self._started = False
        self._extreme = 0.0
        self._rising = True
        self._last_swing = 0.0
        self._swings = 0
        self._age = 0.0
        self._turning_point = 0.0

    def update(self, pressure: float, dt: float) -> bool:
        """Process one reading and return whether the pressure oscillates.

        Parameters
        ----------
        pressure
            As a share of the goal.
        dt
            Time since the last reading, s.
        """
        self._age += dt
        if not self._started:
            self._extreme = self._turning_point = pressure
            self._started = True
            return False
        if self._age > MAX_SWING_SECONDS:
            self._swings, self._last_swing, self._age = 0, 0.0, 0.0
            # The next swing starts here: the change since the last turning point was too slow.
            self._turning_point = self._extreme = pressure
        further = pressure > self._extreme if self._rising else pressure < self._extreme
        if further:
            self._extreme = pressure
        elif abs(pressure - self._extreme) > 0.5 * MIN_SWING:
            self._end_swing(pressure)
        return self._swings >= MAX_SWINGS

    def _end_swing(self, pressure: float) -> None:
        """Count the swing that ended at the extreme, and reverse the direction."""
        swing = abs(self._extreme - self._turning_point)
        lasting = swing >= MIN_SWING and swing >= DECAY * self._last_swing
        self._swings = self._swings + 1 if lasting else 0
        self._last_swing = swing
        self._turning_point, self._extreme = self._extreme, pressure
        self._rising = not self._rising
        self._age = 0.0

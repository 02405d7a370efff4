"""Detection of a pressure that oscillates and does not settle."""

from __future__ import annotations

MIN_SWING = 0.5
"""Minimum swing that counts, from one turning point to the next, as a share of the goal pressure.
Noise changes its direction often, but with small swings."""
OSCILLATION_SWINGS = 5
"""Minimum number of successive swings without decay that counts as an oscillation."""
MAX_SWING_SECONDS = 0.5
"""Maximum time of one swing, s. Slower changes come from the object."""
DECAY = 0.9
"""A swing below this share of the one before counts as decaying. A slower decay takes too long: at
this ratio, the amplitude halves only after seven swings."""


class OscillationDetector:
    """Detect large swings of the pressure that do not decay.

    The pressure also swings after contact, but then each swing is smaller than the one before.
    Swings that do not decay show that the control loop is close to instability, or that the object
    moves.
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
        self._swing_seconds = 0.0
        self._turning_point = 0.0

    def update(self, pressure: float, dt: float) -> bool:
        """Process one reading and return whether the pressure oscillates.

        Parameters
        ----------
        pressure
            Pressure divided by the goal pressure.
        dt
            Time since the last reading, s.
        """
        self._swing_seconds += dt
        if not self._started:
            self._extreme = self._turning_point = pressure
            self._started = True
            return False
        if self._swing_seconds > MAX_SWING_SECONDS:
            self._swings, self._last_swing, self._swing_seconds = 0, 0.0, 0.0
            # The next swing starts here: the change since the last turning point was too slow.
            self._turning_point = self._extreme = pressure
        further = pressure > self._extreme if self._rising else pressure < self._extreme
        if further:
            self._extreme = pressure
        # Noise does not reach half of the minimum swing, so it cannot end a swing.
        elif abs(pressure - self._extreme) > 0.5 * MIN_SWING:
            self._end_swing(pressure)
        return self._swings >= OSCILLATION_SWINGS

    def _end_swing(self, pressure: float) -> None:
        """Count the swing that ended at the extreme, and reverse the direction."""
        swing = abs(self._extreme - self._turning_point)
        sustained = swing >= MIN_SWING and swing >= DECAY * self._last_swing
        self._swings = self._swings + 1 if sustained else 0
        self._last_swing = swing
        self._turning_point, self._extreme = self._extreme, pressure
        self._rising = not self._rising
        self._swing_seconds = 0.0

"""Notice a pressure that swings and does not calm down."""

from __future__ import annotations


class OscillationDetector:
    """Follow the turning points of the pressure; tell when swings are large and do not shrink.

    A landing swings too, but each swing is smaller than the one before; noise turns often, but by
    little. What is left is a loop that is unstable or close to it.

    Parameters
    ----------
    least
        Smallest swing, turning point to turning point, that counts, in the unit of the readings.
    swings
        How many swings in a row must not shrink.
    longest
        Longest time of one swing, s: slower changes are the object's.
    """

    SHRINKING = 0.9
    """A swing below this share of the one before shrinks: with it a loop settles in a second."""

    def __init__(self, least: float, swings: int, longest: float) -> None:
        self._least, self._swings, self._longest = least, swings, longest
        self.reset()

    def reset(self) -> None:
        """Forget all swings."""
        self._started = False
        self._extreme = 0.0
        self._rising = True
        self._last_swing = 0.0
        self._in_a_row = 0
        self._age = 0.0
        self._turn = 0.0

    def update(self, pressure: float, dt: float) -> bool:
        """Take one reading, after ``dt`` s, and tell whether it swings on."""
        self._age += dt
        if not self._started:
            self._extreme = self._turn = pressure
            self._started = True
            return False
        if self._age > self._longest:
            self._in_a_row, self._last_swing, self._age = 0, 0.0, 0.0
            # The next swing counts from here: the way since the last turn was no swing.
            self._turn = self._extreme = pressure
        further = pressure > self._extreme if self._rising else pressure < self._extreme
        if further:
            self._extreme = pressure
        elif abs(pressure - self._extreme) > 0.5 * self._least:
            self._turn_around(pressure)
        return self._in_a_row >= self._swings

    def _turn_around(self, pressure: float) -> None:
        """The extreme was a turning point: judge the swing that ended there."""
        swing = abs(self._extreme - self._turn)
        grown = swing >= self._least and swing >= self.SHRINKING * self._last_swing
        self._in_a_row = self._in_a_row + 1 if grown else 0
        self._last_swing = swing
        self._turn, self._extreme = self._extreme, pressure
        self._rising = not self._rising
        self._age = 0.0

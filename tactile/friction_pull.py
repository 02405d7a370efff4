"""Estimate the friction of a grasped object by a small deliberate pull with eased grip."""

from __future__ import annotations

from math import exp, log

_MAX_FRICTION = 3.0
"""Maximum estimate that makes sense."""
_FILTER_TIME = 0.02
"""Time constant of the filter of both forces, s."""
_WATCH_TIME = 0.08
"""Time over which the ratio must rise, s. With 0.03 s noise of the wrist ends the pull early."""
_MIN_RISE = 0.3
"""Rise of the log of the ratio, as a share of the fall of the log of the grip. Below it the ratio
counts as hanging. An object that sticks has 1, and one that slides 0."""

_EASE_TIME = 0.25
"""Time in which the grip falls to 1/e, s. A slower pull averages more noise."""
_MIN_LOAD = 0.15
"""Tangential force from which the ratio counts, N: above the force sensor's noise."""
_MIN_GRIP = 0.15
"""Grip force at which the pull ends, N."""
_MIN_FRICTION = 0.15
"""Estimate below which the pull is repeated, as noise has ended it too early. No pad of foam
or rubber is so slippery."""


class FrictionPull:
    """The estimation of friction by a small pull at a grasped object.

    The hand lifts by a few millimetres, at 4 mm/s, while the grip is eased. A slower hand finds the
    static friction, which does not hold an object that slides. The ratio of tangential to normal
    force rises until the object slides. From then on the ratio is the friction. An estimate that is
    too low to be true restarts the pull once, from its first grip force.

    Parameters
    ----------
    grip
        Grip force at the start, N.
    """

    def __init__(self, grip: float) -> None:
        self._grip = self._first_grip = grip
        self._repeated = False
        self._normal = self._tangential = 0.0
        self._started = False
        self._past: list[tuple[float, float, float]] = []
        self._time = 0.0
        self.friction: float | None = None
        """Estimated friction; None until the object has slid, and if no estimate makes sense."""
        self.done = False
        """Whether the pull has ended: the object has slid, or the grip is at its minimum."""

    @property
    def ratio(self) -> float:
        """Filtered ratio of tangential to normal force; a sticking object has at least it."""
        return self._tangential / self._normal if self._normal > 0.0 else 0.0

    def update(self, normal: float, tangential: float, dt: float) -> float:
        """Enter a reading, and return the grip force to command, N.

        Parameters
        ----------
        normal
            Normal force on one pad, N.
        tangential
            Amount of the tangential force on one pad, N.
        dt
            Time since the last reading, s.
        """
        share = 1.0 - exp(-dt / _FILTER_TIME) if self._started else 1.0
        self._started = True
        self._time += dt
        self._normal += share * (normal - self._normal)
        self._tangential += share * (tangential - self._tangential)
        if self.done:
            return self._grip
        if self._tangential < _MIN_LOAD or self._normal <= 0.0:
            # The pull has not begun to load the object.
            return self._grip
        self._past.append((self._time, log(self._normal), log(self._tangential / self._normal)))
        while len(self._past) > 1 and self._past[1][0] <= self._time - _WATCH_TIME:
            self._past.pop(0)
        begun, first_grip, first_ratio = self._past[0]
        _, grip, ratio = self._past[-1]
        fallen = first_grip - grip
        watched = self._time - begun >= 0.9 * _WATCH_TIME
        if watched and fallen > 0.0 and ratio - first_ratio < _MIN_RISE * fallen:
            best = exp(max(entry[2] for entry in self._past))
            if best < _MIN_FRICTION and not self._repeated:
                self._repeated = True
                self._past.clear()
                self._grip = self._first_grip
                return self._grip
            self.friction = min(best, _MAX_FRICTION) if best >= _MIN_FRICTION else None
            self.done = True
        elif self._grip <= _MIN_GRIP:
            self.done = True
        self._grip = max(self._grip * exp(-dt / _EASE_TIME), _MIN_GRIP)
        return self._grip

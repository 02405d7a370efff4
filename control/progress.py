"""Whether the errors of a motion still fall."""

from __future__ import annotations

MIN_PROGRESS = 0.01
"""Minimum decrease of an error that counts as progress, m or rad. With a larger value, a slow
motion counts as stuck earlier."""
RELATIVE_PROGRESS = 0.1
"""A decrease by this fraction of the smallest error so far counts as progress too. It is the
smaller one near the goal."""


class Progress:
    """The smallest errors of a motion so far, and the time since one of them fell."""

    def __init__(self, tolerance: float, dt: float) -> None:
        self._tolerance, self._dt = tolerance, dt
        self.restart()

    def restart(self) -> None:
        """Forget all errors."""
        self._best: tuple[float, ...] = ()
        self._stalled = 0.0

    def time_without(self, errors: tuple[float, ...]) -> float:
        """Return the time without progress, s: no error fell enough below its minimum so far.

        Call it once per cycle. When an error falls, the minima of the tasks below it are reset,
        because their errors may have to grow. Each error can fall only a limited number of times,
        so every motion ends.
        """
        if not self._best:
            self._best, self._stalled = errors, 0.0
            return 0.0
        for index, (error, best) in enumerate(zip(errors, self._best, strict=True)):
            if best > self._tolerance and (
                error < best - MIN_PROGRESS or error < best - RELATIVE_PROGRESS * best
            ):
                self._best = (*self._best[:index], *errors[index:])
                self._stalled = 0.0
                return 0.0
        self._stalled += self._dt
        return self._stalled

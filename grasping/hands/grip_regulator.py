"""Set the tension of the fingers so that the pads press with a wanted force."""

from __future__ import annotations

import numpy as np

from .closing import Closing

FEELING_SECONDS, REGULATION_SECONDS = 0.03, 0.1
"""Time constants of the filter of the force on the pads, and of correcting it, s. Pads on an object
that moves bounce."""
READING_SECONDS = 0.04
"""Assumed lateness of the pads' readings while the grip is relaxed, s. The readings of slow pads
are still high then. Without this, the grip on a light object undershot to nothing."""
RATIO_RANGE = (0.3, 1.2)
"""Range of the ratio of tension and force on the pads, as a multiple of the usual ratio. It depends
on the size of the object."""

TIGHTENING_RATE = 600.0
"""Rate at which the tension rises while the hand takes over the weight, N/s."""


class GripRegulator:
    """Control the force of all pads together by the tension of the fingers.

    Parameters
    ----------
    closing
        The controller of the fingers. It obeys while it holds an object.
    """

    def __init__(self, closing: Closing) -> None:
        self._closing = closing
        self._wanted: float | None = None
        self._felt = self._expected = 0.0
        self._ratio = closing.tension_per_force

    def settle(self) -> None:
        """Begin :meth:`press` again at the next measured force."""
        self._wanted = None

    def tighten(self, force: float, dt: float) -> None:
        """Raise the tension, if it is lower, to that of a force of all pads together, N."""
        closing = self._closing
        goal = closing.tension_per_force * force
        if goal > closing.tension:
            closing.pull_with(min(closing.tension + TIGHTENING_RATE * dt, goal))

    def tighten_fully(self, dt: float) -> None:
        """Raise the tension, if it is lower, to that of the grip before it was regulated."""
        closing = self._closing
        if closing.tension < closing.grip_tension:
            raised = closing.tension + TIGHTENING_RATE * dt
            closing.pull_with(min(raised, closing.grip_tension))

    def press(self, force: float, measured: float, dt: float) -> None:
        """Change the tension so that all pads together press with a force, N.

        Parameters
        ----------
        force
            Wanted force, N. The tension follows its change at once.
        measured
            Force that the pads measure, N. It corrects the tension slowly.
        dt
            Control period, s.
        """
        closing = self._closing
        if self._wanted is None:
            self._wanted = self._felt = self._expected = measured
            usual = closing.tension_per_force
            share = closing.tension / max(usual * measured, 1.0)
            self._ratio = usual * float(np.clip(share, *RATIO_RANGE))
        self._felt += (measured - self._felt) * dt / FEELING_SECONDS
        late = FEELING_SECONDS + READING_SECONDS
        self._expected = max(self._expected + (force - self._expected) * dt / late, force)
        change = force - self._wanted + (self._expected - self._felt) * dt / REGULATION_SECONDS
        self._wanted = force
        closing.pull_with(closing.tension + self._ratio * change)

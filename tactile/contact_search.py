"""Look for a lost contact: lift, shift, descend, a few times."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .phase_options import PhaseOptions

TURN = math.radians(120.0)
"""Angle between the directions of two tries: three of them go all around."""
ARRIVED_M = 1e-6
"""Rest of a way that counts as none."""


class ContactSearch:
    """One search: the first try where contact was lost, the others a step around it.

    Parameters
    ----------
    centre
        Where on the pad the contact was last, (x, y), m: if it slipped off, then that way, so that
        is where the second try goes.
    options
        Number of tries, lengths and speeds.
    """

    def __init__(self, centre: tuple[float, float], options: PhaseOptions) -> None:
        self._options = options
        self._heading = math.atan2(centre[1], centre[0])
        self._place = np.zeros(3)
        self._try = 0
        self._stage: Literal["lift", "shift", "descend"] = "lift"

    @property
    def over(self) -> bool:
        """Whether all tries were in vain."""
        return self._try >= self._options.searches

    def step(self, touching: bool, dt: float) -> NDArray[np.float64]:
        """Give the velocity of this cycle in the sensor's frame, (3,), m/s.

        Parameters
        ----------
        touching
            Whether anything touches: the pad is not shifted along what it touches.
        dt
            Cycle time, s.
        """
        o = self._options
        if self.over:
            return np.zeros(3)
        goal, speed = self._place.copy(), o.search_speed
        if self._stage == "shift" and touching:
            return np.array([0.0, 0.0, -speed])
        if self._stage == "lift":
            goal[2] = -o.search_lift
        elif self._stage == "shift":
            goal[:2] = self._spot()
        else:
            goal[2], speed = o.search_depth, o.approach_speed
        way = goal - self._place
        rest = float(np.linalg.norm(way))
        if rest <= max(ARRIVED_M, 1e-3 * speed * dt):
            self._next_stage()
            return np.zeros(3)
        velocity = way / rest * min(speed, rest / dt)
        self._place += velocity * dt
        return velocity

    def _spot(self) -> NDArray[np.float64]:
        if self._try == 0:
            return np.zeros(2)
        angle = self._heading + (self._try - 1) * TURN
        return self._options.search_step * np.array([math.cos(angle), math.sin(angle)])

    def _next_stage(self) -> None:
        if self._stage == "lift":
            self._stage = "shift"
        elif self._stage == "shift":
            self._stage = "descend"
        else:
            self._stage = "lift"
            self._try += 1

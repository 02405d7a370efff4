"""Search for a lost contact: lift, shift, descend, at several places."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

LIFT = 0.005
"""Height above the object before an attempt, m."""
STEP = 0.01
"""Distance along the surface from the first attempt to another, m."""
SPEED = 0.05
"""Speed of lifting and shifting, m/s."""
DEPTH = 0.01
"""Descent of an attempt beyond where the contact was lost, m."""
TURN = math.radians(120.0)
"""Angle between the directions of two attempts, rad. Three attempts cover all directions."""
ARRIVED = 1e-6
"""Remaining distance that counts as none, m."""


class ContactSearch:
    """One search: the first attempt where contact was lost, the others one step around it.

    Parameters
    ----------
    centre
        Last centre of pressure on the pad, (x, y), m. A contact that slipped off did so in this
        direction, so the second attempt goes there.
    attempts
        Number of attempts.
    descend_speed
        Speed towards the object, m/s.
    """

    def __init__(self, centre: tuple[float, float], attempts: int, descend_speed: float) -> None:
        self._attempts, self._descend_speed = attempts, descend_speed
        self._heading = math.atan2(centre[1], centre[0])
        self._position = np.zeros(3)
        self._attempt = 0
        self._stage: Literal["lift", "shift", "descend"] = "lift"

    @property
    def over(self) -> bool:
        """Whether all attempts have failed."""
        return self._attempt >= self._attempts

    def step(self, touching: bool, dt: float) -> NDArray[np.float64]:
        """Compute the velocity of this cycle in the sensor's frame, (3,), m/s.

        Parameters
        ----------
        touching
            Whether there is a contact. The pad does not shift along an object that it touches.
        dt
            Cycle time, s.
        """
        if self.over:
            return np.zeros(3)
        goal, speed = self._position.copy(), SPEED
        if self._stage == "shift" and touching:
            return np.array([0.0, 0.0, -speed])
        if self._stage == "lift":
            goal[2] = -LIFT
        elif self._stage == "shift":
            goal[:2] = self._offset()
        else:
            goal[2], speed = DEPTH, self._descend_speed
        path = goal - self._position
        distance = float(np.linalg.norm(path))
        if distance <= max(ARRIVED, 1e-3 * speed * dt):
            self._next_stage()
            return np.zeros(3)
        velocity = path / distance * min(speed, distance / dt)
        self._position += velocity * dt
        return velocity

    def _offset(self) -> NDArray[np.float64]:
        """Return the place of the attempt relative to the first one, (2,), m."""
        if self._attempt == 0:
            return np.zeros(2)
        angle = self._heading + (self._attempt - 1) * TURN
        return STEP * np.array([math.cos(angle), math.sin(angle)])

    def _next_stage(self) -> None:
        if self._stage == "lift":
            self._stage = "shift"
        elif self._stage == "shift":
            self._stage = "descend"
        else:
            self._stage = "lift"
            self._attempt += 1

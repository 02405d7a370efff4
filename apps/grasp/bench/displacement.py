"""Displacement of the target from its first contact with the robot to the hold."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from eyehand.data_synth.cell import SimRobot

HELD = "lift"
"""First phase in which the object is held."""


class Displacement:
    """The displacement of one target, updated in every control cycle.

    Parameters
    ----------
    robot
        The simulated robot.
    target
        Name of the target; empty for none.
    """

    def __init__(self, robot: SimRobot, target: str) -> None:
        self._robot, self._target = robot, target
        self._start: np.ndarray | None = None
        self.metres: float | None = None
        """The displacement, m; None before the hold."""

    @property
    def active(self) -> bool:
        """Whether the object is not held yet."""
        return bool(self._target) and self.metres is None

    def update(self, phase: str, touched: Collection[str]) -> None:
        """Note the phase, and the names of what the robot touched in the last cycle."""
        if not self.active or (self._start is None and self._target not in touched):
            return
        place = np.array(self._robot.object_pose(self._target).translation)
        if self._start is None:
            self._start = place
        if phase == HELD:
            self.metres = float(np.linalg.norm(place - self._start))

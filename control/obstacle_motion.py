"""The velocity of obstacles, given or estimated from their successive poses."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform

WINDOW = 0.15
"""Time over which poses are fitted by a straight line, s. A longer one averages more noise, and
notices later that an obstacle turns or stops."""
MAX_AGE = 0.25
"""Time after which an obstacle without a new pose counts as standing still, s."""
MAX_SPEED = 3.0
"""Maximum estimated speed, m/s. An obstacle that went faster was put to another place."""
SURE = 2.0
"""An estimated speed below this many standard deviations is noise."""


class ObstacleMotions:
    """Twists [v; ω] (6,) of obstacles by name, world axes, m/s and rad/s.

    Time is the time of the control cycles, so that a simulation may run at any pace. A velocity
    that is not given is the slope of a line through the poses of the last WINDOW.
    """

    def __init__(self) -> None:
        self.clock = 0.0
        """Time of the control cycles so far, s."""
        self._tracks: dict[str, deque[tuple[float, RigidTransform]]] = {}
        self._twists: dict[str, NDArray[np.float64]] = {}
        self._deviations: dict[str, float] = {}

    def twist(self, name: str) -> NDArray[np.float64]:
        """Return the twist of an obstacle; zero if it stands still."""
        return self._twists.get(name, np.zeros(6))

    def deviation(self, name: str) -> float:
        """Return the standard deviation of the estimated velocity, m/s; 0 if it was given."""
        return self._deviations.get(name, 0.0)

    def advance(self, dt: float) -> list[tuple[str, NDArray[np.float64]]]:
        """Advance the time, and return how far (3,) each estimated obstacle has moved on, m.

        An obstacle without a new pose for MAX_AGE stands still at its last pose.
        """
        self.clock += dt
        if not self._tracks:
            return []
        shifts = []
        for name in list(self._tracks):
            if name not in self._twists:
                continue
            age = self.clock - self._tracks[name][-1][0]
            shifts.append((name, age * self._twists[name][:3]))
            if age > MAX_AGE:
                self.forget(name)
                shifts[-1] = (name, np.zeros(3))
        return shifts

    def forget(self, name: str) -> None:
        """Forget an obstacle: it stands still."""
        for entries in (self._tracks, self._twists, self._deviations):
            entries.pop(name, None)

    def give(self, name: str, twist: NDArray[np.float64]) -> None:
        """Set the twist of an obstacle."""
        self.forget(name)
        self._twists[name] = twist

    def observe(self, name: str, pose: RigidTransform) -> None:
        """Estimate the twist of an obstacle from a new pose."""
        track = self._tracks.setdefault(name, deque())
        while track and (track[-1][0] >= self.clock or track[0][0] < self.clock - WINDOW):
            # Poses of one moment: only the last counts.
            track.pop() if track[-1][0] >= self.clock else track.popleft()
        if track:
            time, last = track[-1]
            moved = float(np.linalg.norm(pose.translation - last.translation))
            if moved > MAX_SPEED * (self.clock - time):
                track.clear()
        track.append((self.clock, pose))
        twist, deviation = _fitted(track)
        speed = float(np.linalg.norm(twist[:3]))
        if speed < SURE * deviation:
            twist[:3] = 0.0
        self._deviations[name] = deviation
        if np.any(twist):
            self._twists[name] = twist
        else:
            self._twists.pop(name, None)


def _fitted(track: deque[tuple[float, RigidTransform]]) -> tuple[NDArray[np.float64], float]:
    """Return the twist (6,) of a line through poses, and the deviation of its speed, m/s."""
    twist = np.zeros(6)
    if len(track) < 2:
        return twist, 0.0
    times = np.array([time for time, _ in track])
    positions = np.array([pose.translation for _, pose in track])
    times = times - times.mean()
    spread = float(times @ times)
    centred = positions - positions.mean(axis=0)
    twist[:3] = times @ centred / spread
    turned = track[-1][1].rotation * track[0][1].rotation.inv()
    twist[3:] = turned.as_rotvec() / (times[-1] - times[0])
    deviation = 0.0
    if len(track) > 2:
        rest = centred - times[:, None] * twist[:3]
        deviation = float(np.sqrt(np.sum(rest**2) / (3 * (len(track) - 2)) / spread))
    return twist, deviation

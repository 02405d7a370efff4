"""Cables of unknown shape that lie on a table, each from a seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.data_synth.pad import TouchObject, cable
from eyehand.errors import InputError

CABLE_RADIUS = 0.003
"""Radius of a mains cable, m."""
LENGTH = 0.42
"""Length of a cable, m. The arm reaches it with a flat pad and no joint near its limit."""
MAX_CURVATURE = 1 / 0.055
"""Maximum curvature, 1/m. The bends of a mains cable have a radius of 5 to 6 cm."""
WAVES = (1, 2, 3)
"""Numbers of waves of the curvature over the length. Their random sum makes cables differ."""
STRAIGHT_START = 0.06
"""Length over which the curvature grows from 0, m. The pad lands where the cable is straight."""
SPACING = 0.0005
"""Distance between points of the true line, m."""
CAPSULE_LENGTH = 0.005
"""Length of the capsules that form the cable, m. They deviate by 0.06 mm in the sharpest bend."""


@dataclass(frozen=True)
class CableShape:
    """A cable that lies on a table."""

    line: NDArray[np.float64]
    """Evenly spaced points of the middle line, (M, 2), m, in the cable's frame. The cable runs
    along +y on the whole. The origin is the middle of its extent."""
    curvature: NDArray[np.float64]
    """Curvature at each point, (M,), 1/m."""

    def touch_object(self) -> TouchObject:
        """Return the object to touch, with its top at z = 0."""
        step = round(CAPSULE_LENGTH / SPACING)
        middle = np.column_stack([self.line, np.full(len(self.line), -CABLE_RADIUS)])
        return cable(middle[::step], CABLE_RADIUS)

    def direction(self, number: int) -> float:
        """Return the direction of the line at point `number`, rad from x."""
        before, after = max(number - 1, 0), min(number + 1, len(self.line) - 1)
        dx, dy = self.line[after] - self.line[before]
        return float(np.arctan2(dy, dx))


def cable_shape(seed: int) -> CableShape:
    """Return a random cable.

    Raises
    ------
    InputError
        If the seed is negative.
    """
    if seed < 0:
        raise InputError(f"seed must be >= 0, got {seed}")
    rng = np.random.default_rng(seed)
    length = np.arange(0.0, LENGTH + SPACING / 2, SPACING)
    curvature = np.zeros(len(length))
    for waves in WAVES:
        phase = rng.uniform(0.0, 2 * np.pi)
        curvature += rng.uniform(0.4, 1.0) * np.sin(2 * np.pi * waves * length / LENGTH + phase)
    curvature *= np.clip(length / STRAIGHT_START, 0.0, 1.0)
    curvature *= MAX_CURVATURE / np.abs(curvature).max()
    heading = np.cumsum(curvature) * SPACING
    heading += np.pi / 2 - heading.mean()
    line = SPACING * np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    line -= 0.5 * (line.min(axis=0) + line.max(axis=0))
    return CableShape(line, curvature)

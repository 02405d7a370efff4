"""Cables of unknown shape that lie on a table, each from a seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.data_synth.pad import CABLE_RADIUS, TouchObject, cable
from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

LENGTH = 0.42
"""Of a cable, m: what the arm reaches with the pad flat and no joint near its limit."""
MAX_CURVATURE = 1 / 0.055
"""Curvature of the sharpest bend, 1/m: a mains cable lies in bends of 5 to 6 cm."""
WAVES = (1, 2, 3)
"""Waves of the curvature over the length: an S, and what makes each cable another."""
STRAIGHT_START = 0.06
"""Way over which the curvature grows from 0, m: the pad lands where it is nearly straight."""
SPACING = 0.0005
"""Between points of the true line, m."""
CAPSULE_LENGTH = 0.005
"""Of the solids that the cable is put together from, m: 0.06 mm from the arc in the sharpest
bend."""


@dataclass(frozen=True)
class CableShape:
    """A cable that lies on a table."""

    line: NDArray[np.float64]
    """Its middle, (M, 2), m, evenly spaced, in the cable's frame: on the whole along +y, the
    middle of its extent at the origin."""
    curvature: NDArray[np.float64]
    """(M,), 1/m."""

    def thing(self) -> TouchObject:
        """Give the object to touch; its top is at z = 0."""
        step = round(CAPSULE_LENGTH / SPACING)
        return cable(np.column_stack([self.line, np.full(len(self.line), -CABLE_RADIUS)])[::step])

    def direction(self, number: int) -> float:
        """Give the direction of the line at one of its points, rad from x."""
        before, after = max(number - 1, 0), min(number + 1, len(self.line) - 1)
        dx, dy = self.line[after] - self.line[before]
        return float(np.arctan2(dy, dx))


def cable_shape(seed: int) -> CableShape:
    """Draw a cable.

    Raises
    ------
    InputError
        If the seed is negative.
    """
    if seed < 0:
        raise InputError(f"seed must be >= 0, got {seed}")
    rng = np.random.default_rng(seed)
    way = np.arange(0.0, LENGTH + SPACING / 2, SPACING)
    curvature = np.zeros(len(way))
    for waves in WAVES:
        phase = rng.uniform(0.0, 2 * np.pi)
        curvature += rng.uniform(0.4, 1.0) * np.sin(2 * np.pi * waves * way / LENGTH + phase)
    curvature *= np.clip(way / STRAIGHT_START, 0.0, 1.0)
    curvature *= MAX_CURVATURE / np.abs(curvature).max()
    heading = np.cumsum(curvature) * SPACING
    heading += np.pi / 2 - heading.mean()
    line = SPACING * np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)
    line -= 0.5 * (line.min(axis=0) + line.max(axis=0))
    return CableShape(line, curvature)

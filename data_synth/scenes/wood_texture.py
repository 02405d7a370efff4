"""Colour of a wooden table top as a function of position."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

PLANK_WIDTH_M = 0.16
LIGHT_WOOD = (0.82, 0.70, 0.55)
DARK_WOOD = (0.66, 0.51, 0.36)
"""Colours between which the grain varies: red, green, blue."""

_RINGS_PER_M = 24.0
_FIBRES_PER_M = 420.0
_JOINT_WIDTH_M = 0.0016
_JOINT_SHADE = 0.6


def wood_colour(x: ArrayLike, y: ArrayLike) -> NDArray[np.float32]:
    """Return the colour of planks along x at table coordinates.

    Parameters
    ----------
    x, y
        Coordinates of equal shape (…,), m.

    Returns
    -------
    NDArray
        Red, green, blue in [0, 1], (…, 3) float32.
    """
    x = np.asarray(x, dtype=np.float32)
    y = np.asarray(y, dtype=np.float32)
    plank = np.floor(y / PLANK_WIDTH_M)
    # Irrational multiples in place of random numbers: the wood is the same in every scene.
    offset = (plank * 0.7548777 % 1) * 9.0
    along = x + offset
    across = y - (plank + 0.5) * PLANK_WIDTH_M
    wander = 0.035 * np.sin(1.9 * along + offset) + 0.010 * np.sin(5.3 * along + 40 * across)
    rings = _RINGS_PER_M * (across + wander) * (1 + 0.4 * np.sin(17 * across + offset))
    # The cube makes the dark part of a year ring narrower than the light part.
    grain = (0.5 + 0.5 * np.sin(2 * np.pi * rings)) ** 3
    fibre = np.sin(2 * np.pi * _FIBRES_PER_M * across + 5 * np.sin(9 * along + 60 * across))
    fibre *= np.sin(23 * along + 190 * across)
    tone = 0.22 + 0.42 * grain + 0.07 * fibre + 0.30 * (plank * 0.5698403 % 1)
    tone = np.clip(tone, 0.0, 1.0)[..., None]
    colour = (1 - tone) * np.array(LIGHT_WOOD) + tone * np.array(DARK_WOOD)
    to_joint = PLANK_WIDTH_M / 2 - np.abs(across)
    joint = np.clip(to_joint / _JOINT_WIDTH_M, 0.0, 1.0)[..., None]
    return (colour * (_JOINT_SHADE + (1 - _JOINT_SHADE) * joint)).astype(np.float32)

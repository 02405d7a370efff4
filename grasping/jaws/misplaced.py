"""Success of grasps when the hand is misplaced relative to the image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .depth_error import held_probability

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..hands import ParallelHand
    from .options import JawOptions
    from .scored import ScoredCandidates
    from .surface_model import ObjectSurface

SHIFTS = 1.5 * np.array([[0, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
"""Shifts that are tried in the hand's frame, in standard deviations: along the pads' width, and
along the approach. Equal weights give nearly the variance of a normal distribution (0.9). The jaws
make up for a shift along the closing axis."""


def misplaced_term(
    scored: ScoredCandidates, surface: ObjectSurface, hand: ParallelHand, options: JawOptions
) -> NDArray[np.float64]:
    """Return the mean success of a misplaced hand over that of a hand in place, (n,).

    The candidates are those of one object. The standard deviation of each shift is
    `options.calibration_error`.
    """
    count = len(scored.candidates)
    error = options.calibration_error
    if error <= 0.0 or count == 0:
        return np.ones(count)
    steps = error * scored.candidates.rotation @ SHIFTS.T
    tips = (scored.candidates.tip[:, :, None] + steps).transpose(2, 0, 1)
    every = np.tile(np.arange(count), len(SHIFTS))
    moved = scored.candidates.take(every).at(tips.reshape(-1, 3))
    held = held_probability(moved, scored.opening[every], surface, hand, options)
    held = held.reshape(len(SHIFTS), count)
    return np.clip(held.mean(axis=0) / np.maximum(held[0], 1e-6), 0.0, 1.0)

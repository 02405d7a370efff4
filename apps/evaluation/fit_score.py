"""How much of a true solid a fitted one fills."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .true_solid import TrueSolid

SAMPLES = 20_000
"""Random points: the standard error of an IoU of 0.9 is 0.3 %."""
AXES = np.vstack([np.eye(3), -np.eye(3)])


def overlap(first: TrueSolid, second: TrueSolid, seed: int = 0) -> float:
    """Intersection over union of two solids, in [0, 1], by random points in their bounds."""
    reaches = np.maximum(first.support(AXES), second.support(AXES))
    rng = np.random.default_rng(seed)
    points = rng.uniform(-reaches[3:], reaches[:3], (SAMPLES, 3))
    in_first, in_second = first.contains(points), second.contains(points)
    either = np.count_nonzero(in_first | in_second)
    return float(np.count_nonzero(in_first & in_second) / max(either, 1))

"""The options of a cycle as a row of numbers, for compiled kernels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .options import ControlOptions

_NAMES = (
    "dt",
    "near_singular",
    "damping",
    "beta",
    "epsilon",
    "influence",
    "eta",
    "centring",
    "centring_power",
    "safety",
    "margin",
    "damper",
    "recovery_speed",
    "limit_margin",
    "task_weight",
)
(
    DT,
    NEAR_SINGULAR,
    DAMPING,
    BETA,
    EPSILON,
    INFLUENCE,
    ETA,
    CENTRING,
    CENTRING_POWER,
    SAFETY,
    MARGIN,
    DAMPER,
    RECOVERY_SPEED,
    LIMIT_MARGIN,
    TASK_WEIGHT,
) = range(len(_NAMES))
"""Places of the options in the row; a dynamic β is NaN."""


def pack_options(options: ControlOptions) -> NDArray[np.float64]:
    """Row of the options that one cycle needs."""
    values = [getattr(options, name) for name in _NAMES]
    return np.array([math.nan if isinstance(value, str) else float(value) for value in values])

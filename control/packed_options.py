"""The options of a control cycle as a row of numbers, for compiled kernels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .options import ControlOptions

_NAMES = (
    "dt",
    "beta",
    "influence",
    "eta",
    "centring",
    "safety",
    "margin",
    "damper",
    "limit_margin",
)
(DT, BETA, INFLUENCE, ETA, CENTRING, SAFETY, MARGIN, DAMPER, LIMIT_MARGIN) = range(len(_NAMES))
"""Index of each option in the row; a dynamic β is NaN."""
FRAME_SPEED = len(_NAMES)
"""Index of the speed limit of the controlled frame, m/s. It limits the nominal motion."""


def pack_options(options: ControlOptions, frame_speed: float = math.inf) -> NDArray[np.float64]:
    """Return the options that one cycle needs, and the speed limit of the frame, as a row."""
    values = [*(getattr(options, name) for name in _NAMES), frame_speed]
    return np.array([math.nan if isinstance(value, str) else float(value) for value in values])

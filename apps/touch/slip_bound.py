"""A bound of slip detection: alarms of an observer who knows the slide, as late as the sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .slip_trials import SlipTrial

BOUND_ERRORS = (0.0, 10e-6, 20e-6, 50e-6)
"""Standard deviations of the error of each judgement of the slide, m."""


def bound_name(error: float) -> str:
    """Return the name of the observer with an error, m, for tables."""
    return f"bound: true slide, error of {1e6 * error:.0f} µm"


def observed_slides(
    trials: Sequence[SlipTrial], wait: float, error: float, seed: int
) -> list[NDArray[np.float64]]:
    """Return the slide that the observer reads at each judgement of each trial, (T,), m.

    Parameters
    ----------
    trials
        Trials with their true slide.
    wait
        Time after which the sensor's readings arrive, s.
    error
        Standard deviation of the error, independent from judgement to judgement, m.
    seed
        Source of the errors.
    """
    rng = np.random.default_rng((seed, 7))
    return [
        np.interp(trial.time - wait, trial.time, trial.slide, left=0.0)
        + error * rng.standard_normal(len(trial.time))
        for trial in trials
    ]

"""A simulated calibration bench: known, even loads on all tactels at once, and their readings."""

from __future__ import annotations

import numpy as np

from eyehand.errors import InputError
from eyehand.tactile import BenchRun

from .tactile_readout import TactileReadout

_MIN_LOAD_PA = 20.0
"""First load after rest."""
MAX_LOAD_PA = 12e3
"""Default last load: above the pad's range, so that the top of the range is covered."""
_GAUGE_ERROR = 0.002
"""Relative standard deviation of the reference gauge from load to load."""


def run_bench(
    readout: TactileReadout,
    seed: int = 0,
    *,
    loads: int = 120,
    images: int = 8,
    images_at_rest: int = 128,
    max_load: float = MAX_LOAD_PA,
) -> BenchRun:
    """Load a pad in steps, starting from rest, and record gauge and readings.

    Air pressure behind a membrane loads all tactels evenly.

    Parameters
    ----------
    readout
        The pad's electronics.
    seed
        Source of the noise of gauge and readings, >= 0.
    loads
        Number of loads, in even ratios from 20 Pa to the last load: more cost bench time.
    images
        Images at each load: more average out the noise.
    images_at_rest
        Images without load, from which the noise is estimated.
    max_load
        Last load, Pa.

    Returns
    -------
    BenchRun
        Pressures of the gauge (M,), Pa, and readings (M, N).

    Raises
    ------
    InputError
        If the seed is negative, a number is less than 1, or the last load is too low.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    if min(loads, images, images_at_rest) < 1:
        raise InputError(
            "loads, images and images_at_rest must be >= 1, got "
            f"{loads}, {images}, {images_at_rest}"
        )
    if not _MIN_LOAD_PA < max_load < np.inf:
        raise InputError(f"max_load must be > {_MIN_LOAD_PA:g} Pa, got {max_load}")
    rng = np.random.default_rng(seed)
    steps = np.geomspace(_MIN_LOAD_PA, max_load, loads)
    shown = steps * (1 + _GAUGE_ERROR * rng.standard_normal(loads))
    true = np.concatenate([np.zeros(images_at_rest), np.repeat(steps, images)])
    gauge = np.concatenate([np.zeros(images_at_rest), np.repeat(shown, images)])
    raw = np.array([readout.raw(np.full(readout.tactels, load), rng) for load in true])
    return BenchRun(gauge, raw)

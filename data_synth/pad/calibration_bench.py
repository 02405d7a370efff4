"""A simulated calibration bench: even, known loads on all tactels at once, and what they read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError
from eyehand.tactile import BenchRun

if TYPE_CHECKING:
    from .tactile_readout import TactileReadout


@dataclass(frozen=True)
class BenchOptions:
    """How the bench loads the pad: air pressure behind a membrane, so all tactels bear the same.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lowest: float = 20.0
    """First load after rest, Pa."""
    highest: float = 12e3
    """Last load, Pa: above the pad's range, so that its top is seen."""
    loads: int = 120
    """Different loads, in even ratios from the lowest to the highest: more cost bench time."""
    images: int = 8
    """Images at each load."""
    images_at_rest: int = 128
    """Images without load, which tell the noise."""
    gauge_error: float = 0.002
    """Relative standard deviation of the reference gauge from load to load."""

    def __post_init__(self) -> None:
        if not 0 < self.lowest < self.highest < np.inf:
            raise InputError(
                f"loads must be 0 < lowest < highest Pa, got {self.lowest}, {self.highest}"
            )
        if min(self.loads, self.images, self.images_at_rest) < 1:
            raise InputError(
                "loads, images and images_at_rest must be >= 1, got "
                f"{self.loads}, {self.images}, {self.images_at_rest}"
            )
        if not 0 <= self.gauge_error < 1:
            raise InputError(f"gauge_error must be in [0, 1), got {self.gauge_error}")


def run_bench(
    readout: TactileReadout, options: BenchOptions | None = None, seed: int = 0
) -> BenchRun:
    """Load a pad step by step from rest, and record gauge and readings.

    Parameters
    ----------
    readout
        The pad's electronics.
    options
        The loads.
    seed
        Source of the noise of gauge and readings, >= 0.

    Returns
    -------
    BenchRun
        Pressures that the gauge showed (M,) and readings (M, N).

    Raises
    ------
    InputError
        If the seed is negative.
    """
    if seed < 0:
        raise InputError(f"seed must be a whole number >= 0, got {seed}")
    o = options or BenchOptions()
    rng = np.random.default_rng(seed)
    loads = np.geomspace(o.lowest, o.highest, o.loads)
    shown = loads * (1 + o.gauge_error * rng.standard_normal(o.loads))
    true = np.concatenate([np.zeros(o.images_at_rest), np.repeat(loads, o.images)])
    gauge = np.concatenate([np.zeros(o.images_at_rest), np.repeat(shown, o.images)])
    raw = np.array([readout.raw(np.full(readout.tactels, load), rng) for load in true])
    return BenchRun(gauge, raw)

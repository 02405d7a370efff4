"""Fit of each tactel's curve from raw reading to pressure to the readings of a bench."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import isotonic_regression

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

LEVELS = 4096
"""Number of readings of a 12-bit converter."""
LINEAR_RANGE = (100.0, 1000.0)
"""Range of pressures in which Haschke's chapter assumes a linear characteristic, Pa."""
KNOTS = 64
"""Points of a full curve. More points follow the noise, fewer points cut corners."""
MIN_LOADS = 8
"""Number of different pressures that a bench run needs to separate a curve from noise."""


@dataclass(frozen=True)
class BenchRun:
    """The record of a calibration bench: known pressures on all tactels, and their readings.

    Raises
    ------
    InputError
        If shapes disagree, there are fewer than 8 different pressures, or a value is out of range.
    """

    pressures: NDArray[np.float64]
    """Pressure on all tactels, (M,), Pa, >= 0, in any order. The lowest should be 0."""
    raw: NDArray[np.uint16]
    """Readings of the tactels, (M, N), 0..4095."""

    def __post_init__(self) -> None:
        if self.pressures.ndim != 1 or self.raw.shape[:1] != self.pressures.shape:
            raise InputError(
                f"a bench run needs pressures (M,) and raw (M, N), got {self.pressures.shape} and "
                f"{self.raw.shape}"
            )
        if self.raw.ndim != 2 or self.raw.shape[1] < 1:
            raise InputError(f"a bench run needs raw readings (M, N), got {self.raw.shape}")
        if not (np.isfinite(self.pressures).all() and (self.pressures >= 0).all()):
            raise InputError("the bench's pressures must be finite and >= 0 Pa")
        if len(np.unique(self.pressures)) < MIN_LOADS:
            raise InputError(
                f"a bench run needs at least {MIN_LOADS} different pressures, got "
                f"{len(np.unique(self.pressures))}"
            )
        if not np.issubdtype(self.raw.dtype, np.integer):
            raise InputError(f"raw readings must be integers, got {self.raw.dtype}")
        if self.raw.min() < 0 or self.raw.max() >= LEVELS:
            raise InputError(
                f"raw readings must be in 0..{LEVELS - 1}, got {self.raw.min()}..{self.raw.max()}"
            )


def fit_linear(run: BenchRun) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit a line to each tactel's readings in the linear range, as in Haschke's chapter.

    Returns
    -------
    Readings (N, 2) at pressure 0 and at the top of the converter, and the pressures there, Pa. If a
    line does not rise, both pressures are 0.

    Raises
    ------
    InputError
        If fewer than 3 readings are in the linear range.
    """
    inside = (run.pressures >= LINEAR_RANGE[0]) & (run.pressures <= LINEAR_RANGE[1])
    if np.count_nonzero(inside) < 3:
        raise InputError(
            f"a linear calibration needs at least 3 readings from {LINEAR_RANGE[0]:g} to "
            f"{LINEAR_RANGE[1]:g} Pa, got {np.count_nonzero(inside)}"
        )
    design = np.column_stack([np.ones(np.count_nonzero(inside)), run.pressures[inside]])
    (start, gain), *_ = np.linalg.lstsq(design, run.raw[inside].astype(np.float64), rcond=None)
    rising = (gain > 0) & (start < LEVELS - 1)
    start = np.where(rising, start, 0.0)
    top = np.full(len(gain), LEVELS - 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        full = np.where(rising, (top - start) / gain, 0.0)
    return np.column_stack([start, top]), np.column_stack([np.zeros(len(gain)), full])


def fit_characteristic(run: BenchRun) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit each tactel's whole characteristic: means of similar pressures, made monotone.

    Returns
    -------
    Readings (N, K), not decreasing, and the pressures there (N, K), Pa, increasing.
    """
    groups = _group_pressures(run.pressures)
    pressures = np.array([run.pressures[group].mean() for group in groups])
    raw = np.array([run.raw[group].mean(axis=0) for group in groups])
    rising = [isotonic_regression(column, weights=[len(g) for g in groups]).x for column in raw.T]
    return np.array(rising), np.tile(pressures, (run.raw.shape[1], 1))


def tabulate(raws: NDArray[np.float64], pressures: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return each tactel's pressure at every reading, (N, 4096), Pa, >= 0, not decreasing.

    Between knots it is a monotone cubic (Fritsch and Carlson 1980), beyond them the pressure of the
    outermost knot.
    """
    table = np.empty((len(raws), LEVELS), np.float32)
    for tactel, (raw, pressure) in enumerate(zip(raws, pressures, strict=True)):
        # All pressures of a flat part are equally likely, so use their mean.
        levels, where = np.unique(raw, return_inverse=True)
        means = np.bincount(where, pressure) / np.bincount(where)
        if len(levels) < 2:
            table[tactel] = 0.0
            continue
        inside = np.clip(np.arange(LEVELS), levels[0], levels[-1])
        table[tactel] = np.maximum(PchipInterpolator(levels, means)(inside), 0.0)
    return table


def _group_pressures(pressures: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Split readings into at most KNOTS groups; the lowest and highest pressure are own groups."""
    loads, which = np.unique(pressures, return_inverse=True)
    between = np.arange(1, len(loads) - 1)
    parts = np.array_split(between, min(KNOTS - 2, len(between)))
    edges = [np.array([0]), *parts, np.array([len(loads) - 1])]
    return [np.flatnonzero((which >= part[0]) & (which <= part[-1])) for part in edges]

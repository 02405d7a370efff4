"""From a calibration bench's readings to each tactel's curve, raw reading to pressure."""

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
"""Readings that a 12-bit converter can give."""
LINEAR_RANGE = (100.0, 1000.0)
"""Pressures in which the paper takes the characteristic for a straight line, Pa."""
KNOTS = 64
"""Points of a full curve: more follow noise, fewer cut corners."""
FEWEST_READINGS = 8
"""Different loads in a bench run from which a curve can be told from noise."""


@dataclass(frozen=True)
class BenchRun:
    """What a calibration bench recorded: known pressures on all tactels, and their readings.

    Raises
    ------
    InputError
        If shapes disagree, there are fewer than 8 different pressures, none at or near rest, or a
        value is out of range.
    """

    pressures: NDArray[np.float64]
    """Pressure that the bench put on all tactels, (M,), Pa, >= 0, in any order, from rest up."""
    raw: NDArray[np.uint16]
    """What the tactels gave, (M, N), 0..4095."""

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
        if len(np.unique(self.pressures)) < FEWEST_READINGS:
            raise InputError(
                f"a bench run needs at least {FEWEST_READINGS} different pressures, got "
                f"{len(np.unique(self.pressures))}"
            )
        if not np.issubdtype(self.raw.dtype, np.integer):
            raise InputError(f"raw readings must be whole numbers, got {self.raw.dtype}")
        if self.raw.min() < 0 or self.raw.max() >= LEVELS:
            raise InputError(
                f"raw readings must be in 0..{LEVELS - 1}, got {self.raw.min()}..{self.raw.max()}"
            )


def linear_knots(run: BenchRun) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit a straight line to each tactel's readings in the linear range, as the paper does.

    Returns
    -------
    Readings (N, 2) at no pressure and at the top of the converter, and the pressures there, Pa.
    Where a line does not rise, both pressures are 0.

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
        most = np.where(rising, (top - start) / gain, 0.0)
    return np.column_stack([start, top]), np.column_stack([np.zeros(len(gain)), most])


def full_knots(run: BenchRun) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Follow each tactel's whole characteristic: means of near loads, made to rise.

    Returns
    -------
    Readings (N, K), never falling, and the pressures there (N, K), Pa, rising.
    """
    groups = _near_loads(run.pressures)
    pressures = np.array([run.pressures[group].mean() for group in groups])
    raw = np.array([run.raw[group].mean(axis=0) for group in groups])
    rising = [isotonic_regression(column, weights=[len(g) for g in groups]).x for column in raw.T]
    return np.array(rising), np.tile(pressures, (run.raw.shape[1], 1))


def tabulate(raws: NDArray[np.float64], pressures: NDArray[np.float64]) -> NDArray[np.float32]:
    """Give each tactel's pressure at every reading, (N, 4096), Pa, >= 0, never falling.

    Between knots a monotone cubic (Fritsch and Carlson 1980), beyond them the outermost pressure.
    """
    table = np.empty((len(raws), LEVELS), np.float32)
    for tactel, (raw, pressure) in enumerate(zip(raws, pressures, strict=True)):
        # Where a curve is flat, all loads of the flat part are as likely: their mean it is.
        levels, where = np.unique(raw, return_inverse=True)
        means = np.bincount(where, pressure) / np.bincount(where)
        if len(levels) < 2:
            table[tactel] = 0.0
            continue
        at = np.clip(np.arange(LEVELS), levels[0], levels[-1])
        table[tactel] = np.maximum(PchipInterpolator(levels, means)(at), 0.0)
    return table


def _near_loads(pressures: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Split readings into at most KNOTS groups of near loads; rest and full load stay alone."""
    loads, which = np.unique(pressures, return_inverse=True)
    between = np.arange(1, len(loads) - 1)
    parts = np.array_split(between, min(KNOTS - 2, len(between)))
    edges = [np.array([0]), *parts, np.array([len(loads) - 1])]
    return [np.flatnonzero((which >= part[0]) & (which <= part[-1])) for part in edges]

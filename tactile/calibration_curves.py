"""Fit of each tactel's curve from raw reading to pressure to the readings of a bench."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .curve_kernels import fit_cubics, make_monotone

MAX_BITS = 16
"""Maximum bits of a converter: readings are uint16."""
LINEAR_RANGE = (100.0, 1000.0)
"""Range of pressures in which Haschke's chapter assumes a linear characteristic, Pa."""
KNOTS = 64
"""Points of a full curve. More points follow the noise, fewer points cut corners."""
MIN_HIGHEST = 1000.0
"""Minimum of the highest pressure of a bench run, Pa: the top of the chapter's linear range. A
lower one is usually in kPa or psi: pads are loaded with 5 to 1000 of them."""
MAX_LOWEST = 0.02
"""Maximum of the lowest pressure of a bench run, as a share of the highest one: the zero error of a
gauge. The readings at rest are taken there. At a share of 0.06, simulated contacts of 0.03 and
0.3 N read 5 and 1.6 times their force. The air's absolute pressure, 101 kPa, exceeds it."""
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
    """Pressure on all tactels above that of the air, (M,), Pa, >= 0, in any order, from 0 to 1000
    or more."""
    raw: NDArray[np.uint16]
    """Readings of the tactels, (M, N), 0 to 2**bits - 1."""
    bits: int = 12
    """Bits of the converter, 1 to 16."""

    def __post_init__(self) -> None:
        check_bits(self.bits)
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
        low, high = self.pressures.min(), self.pressures.max()
        if high < MIN_HIGHEST:
            raise InputError(
                f"a bench run needs pressures up to {MIN_HIGHEST:g} Pa or more, got at most "
                f"{high:g}: they must be in Pa (1 kPa = 1000 Pa, 1 psi = 6895 Pa)"
            )
        if low > MAX_LOWEST * high:
            raise InputError(
                f"a bench run starts without load, got {low:g} to {high:g} Pa: pressures must be "
                "above the air's, not absolute, and include 0 with its readings at rest"
            )
        if not np.issubdtype(self.raw.dtype, np.integer):
            raise InputError(f"raw readings must be integers, got {self.raw.dtype}")
        if self.raw.min() < 0 or self.raw.max() >= 2**self.bits:
            raise InputError(
                f"raw readings must be in 0..{2**self.bits - 1}, got "
                f"{self.raw.min()}..{self.raw.max()}; set bits for another converter"
            )


def check_bits(bits: int) -> None:
    """Raise an `InputError` if the bits of a converter are out of range."""
    if not 1 <= bits <= MAX_BITS:
        raise InputError(f"bits must be 1 to {MAX_BITS}, got {bits}")


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
    highest = 2.0**run.bits - 1.0
    rising = (gain > 0) & (start < highest)
    start = np.where(rising, start, 0.0)
    top = np.full(len(gain), highest)
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
    rising = np.empty((run.raw.shape[1], len(groups)))
    for k, group in enumerate(groups):
        rising[:, k] = run.raw[group].mean(axis=0)
    make_monotone(rising, np.array([float(len(group)) for group in groups]))
    return rising, np.broadcast_to(pressures, rising.shape)


def fit_curves(raws: NDArray[np.float64], pressures: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return each tactel's curve as knots of a monotone cubic, (N, K, 3), for the kernels.

    Fields are reading, pressure and slope, see `curve_kernels.fit_cubics`. Beyond the knots, the
    pressure is that of the outermost knot.
    """
    curves = np.empty((*raws.shape, 3), np.float32)
    fit_cubics(raws, pressures, curves)
    return curves


def _group_pressures(pressures: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """Split readings into at most KNOTS groups; the lowest and highest pressure are own groups."""
    loads, which = np.unique(pressures, return_inverse=True)
    between = np.arange(1, len(loads) - 1)
    parts = np.array_split(between, min(KNOTS - 2, len(between)))
    edges = [np.array([0]), *parts, np.array([len(loads) - 1])]
    return [np.flatnonzero((which >= part[0]) & (which <= part[-1])) for part in edges]

"""Calibrate a tactile array: convert raw readings to pressures and reject invalid readings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

from .calibration_curves import BenchRun, check_bits, fit_characteristic, fit_curves, fit_linear
from .curve_kernels import curve_pressures, rest_noise
from .feature_kernels import read_pressures
from .image import TactileArray, TactileImage

REST_SHARE = 0.1
"""Fraction of the bench readings, those at the lowest pressures, from which the noise at rest is
estimated."""
MIN_NOISE = 12**-0.5
"""Minimum noise, counts: the quantisation noise of a constant reading."""
MIN_SPAN = 0.1
"""Minimum range of a tactel's readings, as a fraction of the median range of the working tactels. A
tactel with a smaller range is dead."""
DEAD_SHARE = 0.5
"""Minimum reading of a working tactel, as a fraction of its reading at rest. Contact can only raise
the reading, because foam cannot pull."""
MAX_READING = 65535
"""Maximum of uint16."""
DEAD_SIGMAS = 10.0
"""Deviation from the reading at rest, in standard deviations, at which a tactel is dead."""


@dataclass(frozen=True)
class Calibration:
    """Each tactel's curve from raw reading to pressure, and its range of valid readings.

    :func:`calibrate` and :func:`calibrate_linear` compute it. :func:`save_calibration` writes it to
    a file and :func:`load_calibration` reads it.

    Raises
    ------
    InputError
        If shapes disagree, values are not finite, or a curve decreases.
    """

    raws: NDArray[np.float64]
    """Readings at the curves' knots, (N, K), counts, non-decreasing."""
    pressures: NDArray[np.float64]
    """Pressures at the knots, (N, K), Pa, non-decreasing."""
    rest: NDArray[np.float64]
    """Reading of each tactel without contact, (N,), counts."""
    noise: NDArray[np.float64]
    """Standard deviation of readings at rest, (N,), counts."""
    ceiling: NDArray[np.float64]
    """Reading from which a tactel is saturated, (N,), counts. It belongs to the highest pressure of
    the bench."""
    dead: NDArray[np.bool_]
    """Mask of the tactels without a valid reading, (N,)."""
    bits: int = 12
    """Bits of the converter, 1 to 16."""

    def __post_init__(self) -> None:
        check_bits(self.bits)
        count = len(self.rest)
        if self.raws.shape != self.pressures.shape or self.raws.ndim != 2 or count < 1:
            raise InputError(
                f"knots must be (N, K) readings and pressures, got {self.raws.shape} and "
                f"{self.pressures.shape}"
            )
        for name in ("raws", "pressures", "rest", "noise", "ceiling", "dead"):
            values = getattr(self, name)
            if len(values) != count or (name not in ("raws", "pressures") and values.ndim != 1):
                raise InputError(
                    f"{name} must have one row per tactel ({count}), got {values.shape}"
                )
            if not np.isfinite(values).all():
                raise InputError(f"{name} must be finite")
        if (np.diff(self.raws) < 0).any() or (np.diff(self.pressures) < 0).any():
            raise InputError("raws and pressures must be non-decreasing along each curve")

    @property
    def working(self) -> int:
        """Number of tactels that are not dead."""
        return int(np.count_nonzero(~self.dead))

    @cached_property
    def curves(self) -> NDArray[np.float32]:
        """Knots of each tactel's curve from reading to pressure, (N, K, 3), see `fit_curves`."""
        return fit_curves(self.raws, self.pressures)

    @cached_property
    def limits(self) -> NDArray[np.int32]:
        """Lower and upper limit of the valid readings of each tactel, (N, 2).

        A tactel is dead below the lower limit and saturated from the upper limit on.
        """
        dead_level = np.minimum(DEAD_SHARE * self.rest, self.rest - DEAD_SIGMAS * self.noise)
        levels = 2**self.bits
        # A reading of uint16 may exceed the converter's range, so dead tactels have a higher limit.
        low = np.where(self.dead, MAX_READING + 1, np.ceil(np.maximum(dead_level, 0.0)))
        high = np.clip(np.floor(self.ceiling), 1, levels - 1)
        return np.column_stack([low, high]).astype(np.int32)

    def threshold(self, sigmas: float) -> NDArray[np.float64]:
        """Return the pressure of each tactel just above its noise, (N,), Pa.

        The threshold of a dead tactel is the median of the working tactels, because its pressure is
        interpolated from its neighbours.

        Parameters
        ----------
        sigmas
            Distance from the reading at rest, in standard deviations of the noise.
        """
        thresholds = np.empty(len(self.rest))
        curve_pressures(self.curves, np.ceil(self.rest + sigmas * self.noise), thresholds)
        if self.dead.any() and not self.dead.all():
            thresholds[self.dead] = np.median(thresholds[~self.dead])
        return thresholds

    def to_pressure(self, raw: NDArray[np.integer]) -> NDArray[np.float64]:
        """Return the pressures (N,), Pa, of raw readings (N,); 0 for a dead tactel."""
        raw = self._checked(raw)
        pressures = np.empty(len(raw))
        curve_pressures(self.curves, raw, pressures)
        pressures[self.is_dead(raw)] = 0.0
        return pressures

    def to_image(self, raw: NDArray[np.integer], array: TactileArray) -> TactileImage:
        """Return the image of raw readings (N,), with dead tactels interpolated."""
        raw = self._checked(raw)
        if len(array.positions) != len(raw):
            raise InputError(
                f"the array must have {len(raw)} tactels like the calibration, got "
                f"{len(array.positions)}"
            )
        pressures, states = np.empty(len(raw)), np.empty(len(raw), np.uint8)
        read_pressures(
            raw, self.curves, self.limits, array.links, array.geometry, pressures, states
        )
        return TactileImage(pressures, array)

    def is_dead(self, raw: NDArray[np.integer]) -> NDArray[np.bool_]:
        """Return the mask (N,) of tactels that are marked as dead or whose reading is too low."""
        return self._checked(raw) < self.limits[:, 0]

    def is_saturated(self, raw: NDArray[np.integer]) -> NDArray[np.bool_]:
        """Return the mask (N,) of working tactels whose readings (N,) are saturated."""
        raw = self._checked(raw)
        return (raw >= self.limits[:, 1]) & ~self.is_dead(raw)

    def mark_dead_at_rest(self, raw: NDArray[np.integer]) -> Calibration:
        """Return a copy that also marks tactels as dead if they are not at rest without contact.

        Parameters
        ----------
        raw
            Readings of the array without contact, (M, N). A few dozen rows are enough.
        """
        if raw.ndim != 2 or raw.shape[1] != len(self.rest) or len(raw) < 1:
            raise InputError(f"readings at rest must be (M, {len(self.rest)}), got {raw.shape}")
        off = abs(np.median(raw, axis=0) - self.rest) > DEAD_SIGMAS * self.noise
        return replace(self, dead=self.dead | off)

    def with_gains(self, gains: NDArray[np.float64]) -> Calibration:
        """Return a copy for tactels whose gains have changed since; it divides by the gains.

        Parameters
        ----------
        gains
            Pressure of each tactel by this calibration over its true pressure, (N,), > 0, from
            :func:`flat_press_gains`.

        Raises
        ------
        InputError
            If there is not one gain > 0 per tactel.
        """
        if gains.shape != self.rest.shape or not ((gains > 0) & np.isfinite(gains)).all():
            raise InputError(f"gains must be {len(self.rest)} values > 0, got {gains.shape}")
        return replace(self, pressures=self.pressures / gains[:, None])

    def _checked(self, raw: NDArray[np.integer]) -> NDArray[np.integer]:
        if raw.shape != self.rest.shape or raw.dtype.kind not in "ui":
            raise InputError(
                f"raw readings must be {len(self.rest)} integers, got {raw.shape} {raw.dtype}"
            )
        return raw


def calibrate(run: BenchRun) -> Calibration:
    """Fit the whole characteristic of each tactel and invert it. This is the default method.

    Tactels that do not respond are marked as dead. All others are calibrated. Check their
    number by `Calibration.working`.

    Raises
    ------
    InputError
        If no tactel works.
    """
    followed = fit_characteristic(run)
    return _calibration(run, followed, followed)


def calibrate_linear(run: BenchRun) -> Calibration:
    """Fit a line to each tactel's linear range and invert it, as in Haschke's chapter.

    Above this range the results are too low, because the characteristic flattens.

    Raises
    ------
    InputError
        If no tactel works, or fewer than 3 loads are within the linear range.
    """
    return _calibration(run, fit_characteristic(run), fit_linear(run))


def _calibration(
    run: BenchRun,
    followed: tuple[NDArray[np.float64], NDArray[np.float64]],
    curve: tuple[NDArray[np.float64], NDArray[np.float64]],
) -> Calibration:
    """Build a calibration from the fitted characteristic (readings, pressures) and its curve."""
    (readings, loads), (raws, pressures) = followed, curve
    rest, top = readings[:, 0], readings[:, -1]
    lowest = np.argsort(run.pressures, kind="stable")[: max(8, int(REST_SHARE * len(run.raw)))]
    noise = rest_noise(run.raw[lowest], readings, run.pressures[lowest], loads[0])
    noise = np.maximum(noise, MIN_NOISE)
    span = top - rest
    dead = span < DEAD_SIGMAS * noise
    # The pressure is 0 for every reading if the fitted line does not rise.
    dead |= pressures[:, -1] <= pressures[:, 0]
    if dead.all():
        raise InputError(
            f"0 of {len(dead)} tactels work: no reading rises with the pressure, from "
            f"{run.pressures.min():g} to {run.pressures.max():g} Pa by the gauge; check the "
            "pad's supply and cable, and the load of the bench"
        )
    # Use the median of the working tactels only, because most tactels of a pad may be dead.
    dead |= span < MIN_SPAN * np.median(span[~dead])
    return Calibration(raws, pressures, rest, noise, top - noise, dead, run.bits)

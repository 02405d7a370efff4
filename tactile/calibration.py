"""Calibration of a tactile array: from raw readings to pressures, and which readings to trust."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

from .calibration_curves import LEVELS, BenchRun, full_knots, linear_knots, tabulate
from .feature_kernels import pack_geometry, read_pressures
from .image import TactileArray, TactileImage
from .region import pack_links

if TYPE_CHECKING:
    from numpy.typing import NDArray

REST_SHARE = 0.1
"""Share of the bench's readings, those of the lowest loads, that the noise at rest is from."""
LEAST_NOISE = 12**-0.5
"""Counts: a reading that never moves is still rounded to whole counts."""
LEAST_SPAN = 0.1
"""A tactel whose readings span less than this share of the median of those that rise is dead."""
BROKEN_SHARE = 0.5
"""A reading below this share of that at rest comes from a broken tactel: foam cannot pull."""
SURE_SIGMAS = 10.0
"""Noise that a reading must be away from rest before its tactel is called dead."""


@dataclass(frozen=True)
class Calibration:
    """Each tactel's curve from raw reading to pressure, and the readings it can be trusted with.

    Made by :func:`calibrate` or :func:`calibrate_linear`; kept in files by `save_calibration`.

    Raises
    ------
    InputError
        If shapes disagree, values are not finite, or readings fall along a curve.
    """

    raws: NDArray[np.float64]
    """Readings at the curves' knots, (N, K), counts, never falling."""
    pressures: NDArray[np.float64]
    """Pressures there, (N, K), Pa, never falling."""
    rest: NDArray[np.float64]
    """Reading of each tactel that nothing touches, (N,), counts."""
    noise: NDArray[np.float64]
    """Standard deviation of readings at rest, (N,), counts."""
    ceiling: NDArray[np.float64]
    """Reading from which on a tactel feels more than the bench had shown it, (N,), counts."""
    dead: NDArray[np.bool_]
    """Tactels whose readings mean nothing, (N,)."""

    def __post_init__(self) -> None:
        count = len(self.rest)
        if self.raws.shape != self.pressures.shape or self.raws.ndim != 2 or count < 1:
            raise InputError(
                f"knots must be (N, K) readings and pressures, got {self.raws.shape} and "
                f"{self.pressures.shape}"
            )
        for name in ("raws", "pressures", "rest", "noise", "ceiling", "dead"):
            values = getattr(self, name)
            if len(values) != count or (name not in ("raws", "pressures") and values.ndim != 1):
                raise InputError(f"{name} must be one per tactel ({count}), got {values.shape}")
            if not np.isfinite(values).all():
                raise InputError(f"{name} must be finite")
        if (np.diff(self.raws) < 0).any() or (np.diff(self.pressures) < 0).any():
            raise InputError("readings and pressures must not fall along a curve")

    @property
    def working(self) -> int:
        """How many tactels are not dead."""
        return int(np.count_nonzero(~self.dead))

    @cached_property
    def table(self) -> NDArray[np.float32]:
        """Pressure of each tactel at every reading, (N, 4096), Pa."""
        return tabulate(self.raws, self.pressures)

    @cached_property
    def limits(self) -> NDArray[np.int32]:
        """Readings below the first are of a dead tactel, from the second on saturated, (N, 2)."""
        broken = np.minimum(BROKEN_SHARE * self.rest, self.rest - SURE_SIGMAS * self.noise)
        low = np.where(self.dead, LEVELS, np.ceil(np.maximum(broken, 0.0)))
        high = np.clip(np.floor(self.ceiling), 1, LEVELS - 1)
        return np.column_stack([low, high]).astype(np.int32)

    def threshold(self, sigmas: float) -> NDArray[np.float64]:
        """Give the pressure of each tactel just above its noise, (N,), Pa.

        Parameters
        ----------
        sigmas
            How far above the reading at rest, times the noise. A dead tactel, which is judged by
            its neighbours' pressure, gets the median of the others.
        """
        levels = np.clip(np.ceil(self.rest + sigmas * self.noise), 0, LEVELS - 1).astype(np.int64)
        least = self.table[np.arange(len(levels)), levels].astype(np.float64)
        if self.dead.any() and not self.dead.all():
            least[self.dead] = np.median(least[~self.dead])
        return least

    def to_pressure(self, raw: NDArray[np.integer]) -> NDArray[np.float64]:
        """Give the pressures (N,), Pa, of raw readings (N,); 0 where a tactel is dead."""
        raw = self._checked(raw)
        pressures = self.table[np.arange(len(raw)), np.minimum(raw, LEVELS - 1)].astype(np.float64)
        pressures[self.is_dead(raw)] = 0.0
        return pressures

    def to_image(self, raw: NDArray[np.integer], array: TactileArray) -> TactileImage:
        """Give the image of raw readings (N,), dead tactels filled in from their neighbours."""
        raw = self._checked(raw)
        if len(array.positions) != len(raw):
            raise InputError(
                f"the array must have {len(raw)} tactels like the calibration, got "
                f"{len(array.positions)}"
            )
        pressures, states = np.empty(len(raw)), np.empty(len(raw), np.uint8)
        links, geometry = pack_links(array), pack_geometry(array)
        read_pressures(raw, self.table, self.limits, links, geometry, pressures, states)
        return TactileImage(pressures, array)

    def is_dead(self, raw: NDArray[np.integer]) -> NDArray[np.bool_]:
        """Tell which tactels are dead, by the bench or by readings (N,) far below rest."""
        return self._checked(raw) < self.limits[:, 0]

    def is_saturated(self, raw: NDArray[np.integer]) -> NDArray[np.bool_]:
        """Tell which live tactels feel more than they can tell from readings (N,)."""
        raw = self._checked(raw)
        return (raw >= self.limits[:, 1]) & ~self.is_dead(raw)

    def mark_dead_at_rest(self, raw: NDArray[np.integer]) -> Calibration:
        """Mark tactels as dead that read as if touched while nothing touches.

        Parameters
        ----------
        raw
            Readings of the untouched array, (M, N): a few dozen.
        """
        if raw.ndim != 2 or raw.shape[1] != len(self.rest) or len(raw) < 1:
            raise InputError(f"readings at rest must be (M, {len(self.rest)}), got {raw.shape}")
        away = abs(np.median(raw, axis=0) - self.rest) > SURE_SIGMAS * self.noise
        return replace(self, dead=self.dead | away)

    def _checked(self, raw: NDArray[np.integer]) -> NDArray[np.integer]:
        if raw.shape != self.rest.shape or raw.dtype.kind not in "ui":
            raise InputError(
                f"raw readings must be {len(self.rest)} whole numbers, got {raw.shape} {raw.dtype}"
            )
        return raw


def calibrate(run: BenchRun) -> Calibration:
    """Follow each tactel's whole characteristic and invert it: the default.

    Tactels that do not answer are marked as dead, and the others calibrated, however few they are:
    ask `Calibration.working` whether they are enough.

    Raises
    ------
    InputError
        If no tactel works.
    """
    return _calibration(run, *full_knots(run))


def calibrate_linear(run: BenchRun) -> Calibration:
    """Fit a line to each tactel's linear range and invert that, as the paper does.

    Pressures above the range come out too low, as the characteristic flattens.

    Raises
    ------
    InputError
        If no tactel works, or fewer than 3 loads are within the linear range.
    """
    return _calibration(run, *linear_knots(run))


def _calibration(
    run: BenchRun, raws: NDArray[np.float64], pressures: NDArray[np.float64]
) -> Calibration:
    followed, loads = full_knots(run)
    rest, top = followed[:, 0], followed[:, -1]
    lowest = np.argsort(run.pressures, kind="stable")[: max(8, int(REST_SHARE * len(run.raw)))]
    expected = np.column_stack(
        [np.interp(run.pressures[lowest], loads[0], curve) for curve in followed]
    )
    noise = np.maximum((run.raw[lowest] - expected).std(axis=0, ddof=1), LEAST_NOISE)
    span = top - rest
    dead = span < SURE_SIGMAS * noise
    # A line that does not rise gives every reading no pressure.
    dead |= pressures[:, -1] <= pressures[:, 0]
    if dead.all():
        raise InputError(
            f"0 of {len(dead)} tactels work: no reading rises with the pressure, from "
            f"{run.pressures.min():g} to {run.pressures.max():g} Pa by the gauge; look at the "
            "pad's supply and cable, and whether the bench did press"
        )
    # Judged by the living alone: the median of a pad that is mostly dead says nothing.
    dead |= span < LEAST_SPAN * np.median(span[~dead])
    return Calibration(raws, pressures, rest, noise, top - noise, dead)

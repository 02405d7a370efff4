"""The electronics under the foam: each tactel squashes its pressure in its own way, in 12 bits."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, log
from typing import TYPE_CHECKING

import numpy as np
from numba import njit

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

FULL_SCALE = 4095
"""Largest reading of the 12-bit converter, counts."""


@dataclass(frozen=True)
class ReadoutOptions:
    """The family that the tactels' characteristics are drawn from.

    A tactel is conductive foam in a voltage divider. The foam's resistance falls with pressure
    like a power, so the reading is `offset + span * p^g / (p^g + h^g)`: a flat toe, a stretch that
    is near to linear (the chapter's 0.1-1 kPa), and saturation far above `h`. The defaults mimic
    the spread of the 256 curves in the chapter's Fig. 4.
    """

    half_pressure: float = 3e3
    """Median of h, the pressure that gives half the span, Pa: lower sees lighter touches and
    saturates earlier."""
    half_pressure_spread: float = 0.2
    """Standard deviation of log h over the tactels."""
    exponent: float = 1.25
    """Mean of g: above 1 the curve has a toe, at 1.25 the slope is even over the linear range."""
    exponent_spread: float = 0.05
    """Standard deviation of g over the tactels."""
    span: float = 3300.0
    """Median reading from no pressure to saturation, counts."""
    span_spread: float = 0.06
    """Standard deviation of log span."""
    offset: float = 120.0
    """Mean reading without pressure, counts."""
    offset_spread: float = 25.0
    """Standard deviation of the offset over the tactels, counts."""
    noise: float = 2.0
    """Standard deviation of a reading from one image to the next, counts."""

    def __post_init__(self) -> None:
        positive = (self.half_pressure, self.exponent, self.span)
        spreads = (
            self.half_pressure_spread,
            self.exponent_spread,
            self.span_spread,
            self.offset_spread,
            self.noise,
        )
        if not all(0 < value < np.inf for value in positive):
            raise InputError(f"half_pressure, exponent and span must be > 0, got {positive}")
        if not all(0 <= value < np.inf for value in spreads):
            raise InputError(f"spreads and noise must be >= 0, got {spreads}")


@dataclass(frozen=True)
class TactileReadout:
    """The characteristics of one pad's tactels.

    Raises
    ------
    InputError
        If shapes disagree or a faulty tactel does not exist.
    """

    offsets: NDArray[np.float64]
    """(N,), counts."""
    spans: NDArray[np.float64]
    """(N,), counts."""
    half_pressures: NDArray[np.float64]
    """(N,), Pa."""
    exponents: NDArray[np.float64]
    """(N,)."""
    noise: float
    """Standard deviation of a reading, counts."""
    dead: tuple[int, ...] = ()
    """Tactels that read nothing but noise whatever presses: a broken wire."""
    saturated: tuple[int, ...] = ()
    """Tactels that read full scale whatever presses: a short circuit."""
    _gains: NDArray[np.float64] = field(init=False, repr=False)
    _floors: NDArray[np.float64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        count = len(self.offsets)
        for name in ("offsets", "spans", "half_pressures", "exponents"):
            if getattr(self, name).shape != (count,):
                raise InputError(
                    f"{name} must be ({count},) like offsets, got {getattr(self, name).shape}"
                )
        wrong = [k for k in (*self.dead, *self.saturated) if not 0 <= k < count]
        if wrong:
            raise InputError(f"faulty tactels must be in 0..{count - 1}, got {wrong}")
        gains, floors = self.spans.copy(), self.offsets.copy()
        gains[list(self.dead)] = 0.0
        gains[list(self.saturated)] = 0.0
        floors[list(self.dead)] = 0.0
        floors[list(self.saturated)] = np.inf
        object.__setattr__(self, "_gains", gains)
        object.__setattr__(self, "_floors", floors)

    @classmethod
    def draw(
        cls,
        tactels: int = 256,
        options: ReadoutOptions | None = None,
        seed: int = 0,
        dead: tuple[int, ...] = (),
        saturated: tuple[int, ...] = (),
    ) -> TactileReadout:
        """Draw a pad's tactels; the same seed gives the same pad.

        Parameters
        ----------
        tactels
            How many, >= 1.
        options
            The family of characteristics.
        seed
            >= 0.
        dead, saturated
            Faulty tactels, by number.

        Raises
        ------
        InputError
            If the number or seed is out of range, or a faulty tactel does not exist.
        """
        if tactels < 1 or seed < 0:
            raise InputError(f"need tactels >= 1 and seed >= 0, got {tactels} and {seed}")
        o = options or ReadoutOptions()
        rng = np.random.default_rng(seed)
        return cls(
            np.maximum(rng.normal(o.offset, o.offset_spread, tactels), 0.0),
            o.span * np.exp(rng.normal(0.0, o.span_spread, tactels)),
            o.half_pressure * np.exp(rng.normal(0.0, o.half_pressure_spread, tactels)),
            np.maximum(rng.normal(o.exponent, o.exponent_spread, tactels), 0.5 * o.exponent),
            o.noise,
            dead,
            saturated,
        )

    @property
    def tactels(self) -> int:
        """How many there are."""
        return len(self.offsets)

    def clean(self, pressures: NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the readings before noise and conversion.

        Parameters
        ----------
        pressures
            (N,), Pa, >= 0.

        Returns
        -------
        NDArray
            (N,), counts; inf where a tactel is saturated by a fault.
        """
        counts = np.empty(self.tactels)
        _characteristics(
            pressures, self._floors, self._gains, self.half_pressures, self.exponents, counts
        )
        return counts

    def raw(
        self, pressures: NDArray[np.float64], rng: np.random.Generator | None
    ) -> NDArray[np.uint16]:
        """Convert pressures to readings.

        Parameters
        ----------
        pressures
            (N,), Pa, >= 0.
        rng
            Source of the noise; none when not given.

        Returns
        -------
        NDArray
            (N,) uint16, 0..4095.
        """
        counts = self.clean(pressures)
        if rng is not None:
            counts += self.noise * rng.standard_normal(self.tactels)
        return np.clip(np.rint(counts), 0, FULL_SCALE).astype(np.uint16)


@njit(cache=True)
def _characteristics(pressures, offsets, spans, halves, exponents, counts):
    for k in range(len(counts)):
        counts[k] = offsets[k]
        if pressures[k] > 0.0 and spans[k] > 0.0:
            # p^g / (p^g + h^g) without two powers.
            counts[k] += spans[k] / (1.0 + exp(exponents[k] * log(halves[k] / pressures[k])))

"""The electronics under the foam: the characteristic curve of each tactel, read with 12 bits."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import exp, log

import numpy as np
from numba import njit
from numpy.typing import NDArray

from eyehand.errors import InputError

FULL_SCALE = 4095
"""Maximum reading of the 12-bit converter, counts."""

NOISE = 2.0
"""Standard deviation of a reading from one image to the next, counts."""

# A tactel is conductive foam in a voltage divider. The foam's resistance falls with pressure like a
# power, so the reading is offset + span * p^g / (p^g + h^g): a flat toe, a nearly linear range (the
# chapter's 0.1-1 kPa), and saturation far above h. The values below reproduce the spread of the 256
# curves in the chapter's Fig. 4.
_HALF_PRESSURE = 3e3
"""Median of h, the pressure at half the span, Pa. A lower value reads lighter touches and saturates
earlier."""
_HALF_PRESSURE_SPREAD = 0.2
"""Standard deviation of log h over the tactels."""
_EXPONENT = 1.25
"""Mean of g. Above 1 the curve has a toe; at 1.25 the slope is even over the linear range."""
_EXPONENT_SPREAD = 0.05
"""Standard deviation of g over the tactels."""
_SPAN = 3300.0
"""Median difference between no pressure and saturation, counts."""
_SPAN_SPREAD = 0.06
"""Standard deviation of the log of the span."""
_OFFSET = 120.0
"""Mean reading without pressure, counts."""
_OFFSET_SPREAD = 25.0
"""Standard deviation of the offset over the tactels, counts."""


@dataclass(frozen=True)
class TactileReadout:
    """The characteristic curves of a pad's tactels.

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
    common_noise: float = 0.0
    """Standard deviation of the noise that all readings of an image share, counts."""
    dead: tuple[int, ...] = ()
    """Tactels that read only noise under any pressure: a broken wire."""
    saturated: tuple[int, ...] = ()
    """Tactels that read full scale under any pressure: a short circuit."""
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
        *,
        seed: int = 0,
        noise: float = NOISE,
        common_noise: float = 0.0,
        dead: tuple[int, ...] = (),
        saturated: tuple[int, ...] = (),
    ) -> TactileReadout:
        """Draw the characteristics of a pad; the same seed gives the same pad.

        Parameters
        ----------
        tactels
            Number of tactels, >= 1.
        seed
            Source of the characteristics, >= 0.
        noise
            Standard deviation of a reading from one image to the next, counts, >= 0.
        common_noise
            Standard deviation of the noise that all readings of an image share, counts, >= 0.
        dead, saturated
            Numbers of faulty tactels.

        Raises
        ------
        InputError
            If the number, seed or noise is out of range, or a faulty tactel does not exist.
        """
        if tactels < 1 or seed < 0:
            raise InputError(f"need tactels >= 1 and seed >= 0, got {tactels} and {seed}")
        if not (0 <= noise < np.inf and 0 <= common_noise < np.inf):
            raise InputError(f"noise must be >= 0 counts, got {noise} and {common_noise}")
        rng = np.random.default_rng(seed)
        return cls(
            np.maximum(rng.normal(_OFFSET, _OFFSET_SPREAD, tactels), 0.0),
            _SPAN * np.exp(rng.normal(0.0, _SPAN_SPREAD, tactels)),
            _HALF_PRESSURE * np.exp(rng.normal(0.0, _HALF_PRESSURE_SPREAD, tactels)),
            np.maximum(rng.normal(_EXPONENT, _EXPONENT_SPREAD, tactels), 0.5 * _EXPONENT),
            noise,
            common_noise,
            dead,
            saturated,
        )

    @property
    def tactels(self) -> int:
        """Number of tactels."""
        return len(self.offsets)

    def clean(self, pressures: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the readings before noise and conversion.

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
        self,
        pressures: NDArray[np.float64],
        rng: np.random.Generator | None,
        shift: NDArray[np.float64] | None = None,
    ) -> NDArray[np.uint16]:
        """Convert pressures to readings.

        Parameters
        ----------
        pressures
            (N,), Pa, >= 0.
        rng
            Source of the noise; no noise if None.
        shift
            (N,), counts that drift adds to the readings; none if not given.

        Returns
        -------
        NDArray
            (N,) uint16, 0..4095.
        """
        counts = self.clean(pressures)
        if shift is not None:
            counts += shift
        if rng is not None:
            counts += self.noise * rng.standard_normal(self.tactels)
            if self.common_noise > 0.0:
                counts += self.common_noise * rng.standard_normal()
        return np.clip(np.rint(counts), 0, FULL_SCALE).astype(np.uint16)


@njit(cache=True)
def _characteristics(pressures, offsets, spans, halves, exponents, counts):
    for k in range(len(counts)):
        counts[k] = offsets[k]
        if pressures[k] > 0.0 and spans[k] > 0.0:
            # p^g / (p^g + h^g) with a single power.
            counts[k] += spans[k] / (1.0 + exp(exponents[k] * log(halves[k] / pressures[k])))

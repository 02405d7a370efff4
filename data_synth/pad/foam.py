"""The pad: its size, and the pressure of its foam over the compression."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from eyehand.errors import InputError

HARD_SHARE = 0.94
"""Share of the densification strain up to which the formula holds. Beyond it the pressure grows
along the tangent, so the pole of the formula is never reached."""
TABLE_SIZE = 2048
"""Entries of a pressure table: steps of 1.6 µm for a rigid object, exact to 1 Pa at 10 kPa."""
_INVERSION_POINTS = 20000
_MIN_TABLE_PRESSURE = 1e-3


@dataclass(frozen=True)
class Foam:
    """A layer of open-cell foam: linear at small strain, then stiffer as its cells close.

    The pressure at strain e is `modulus * e / (1 - (e / densification)^2)`: the slope is the
    modulus at first, 1.6 times that at half the thickness, and grows without bound towards
    densification, where cell walls touch (after the densification term of Gibson and Ashby,
    Cellular Solids, 1997, chapter 5; their plateau belongs to stiffer foams whose walls buckle).

    The defaults are a soft conductive foam. Half its thickness needs 9.2 kPa, so the sensor's range
    (0.1-10 kPa) needs 2 of its 4 mm, and the linear range (0.1-1 kPa) 0.03-0.33 mm. A rigid face at
    1 mm causes 3.3 kPa. With a stiffer foam, the travel would be too short to control an arm. A
    softer foam would bottom out within the sensor's range.

    Raises
    ------
    InputError
        If a length or modulus is not positive, or the strain not within (0, 1].
    """

    thickness: float = 0.004
    """Height of the unloaded layer, m: more gives more travel, and more blur on a real pad."""
    modulus: float = 12e3
    """Slope of pressure over strain when unloaded, Pa."""
    densification: float = 0.85
    """Strain at which the cells are closed, in (0, 1]: about 1 minus the relative density."""

    def __post_init__(self) -> None:
        if not (0 < self.thickness < np.inf and 0 < self.modulus < np.inf):
            raise InputError(
                f"a foam's thickness and modulus must be > 0, got {self.thickness} m and "
                f"{self.modulus} Pa"
            )
        if not 0 < self.densification <= 1:
            raise InputError(f"densification must lie in (0, 1], got {self.densification}")

    @property
    def hard_depth(self) -> float:
        """Compression beyond which the layer counts as solid, m."""
        return HARD_SHARE * self.densification * self.thickness

    @property
    def hard_pressure(self) -> float:
        """Pressure at `hard_depth`, Pa."""
        return self.modulus * HARD_SHARE * self.densification / (1 - HARD_SHARE**2)

    def pressure(self, compression: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the pressure at a compression.

        Parameters
        ----------
        compression
            (...), m; negative values are gaps without pressure.

        Returns
        -------
        NDArray
            (...), Pa, >= 0.
        """
        squeezed = np.clip(compression, 0.0, self.hard_depth)
        strain = squeezed / self.thickness
        soft = self.modulus * strain / (1 - (strain / self.densification) ** 2)
        return soft + self._hard_slope * np.maximum(compression - self.hard_depth, 0.0)

    def compression(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute the compression at a pressure, the inverse of :meth:`pressure`.

        Parameters
        ----------
        pressure
            (...), Pa, >= 0.

        Returns
        -------
        NDArray
            (...), m.
        """
        soft = np.clip(pressure, 0.0, self.hard_pressure)
        # The positive root of (p / d²) e² + E e - p = 0, in the form without cancellation.
        root = np.sqrt(self.modulus**2 + (2 * soft / self.densification) ** 2)
        strain = 2 * soft / (self.modulus + root)
        hard = np.maximum(pressure - self.hard_pressure, 0.0) / self._hard_slope
        return self.thickness * strain + hard

    @property
    def _hard_slope(self) -> float:
        square = HARD_SHARE**2
        return self.modulus * (1 + square) / (1 - square) ** 2 / self.thickness


@dataclass(frozen=True)
class PadOptions:
    """Size and material of the pad.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    rows: int = 16
    """Tactels along y."""
    columns: int = 16
    """Tactels along x."""
    pitch: float = 0.005
    """Distance between the centres of two tactels, m: smaller resolves finer shapes."""
    friction: float = 0.6
    """Coulomb's coefficient between foam and objects."""

    foam = Foam()
    """The layer of foam that covers the tactels. It is the same on all pads."""

    def __post_init__(self) -> None:
        if self.rows < 1 or self.columns < 1 or not 0 < self.pitch < np.inf:
            raise InputError(
                "rows, columns and pitch must be > 0, got "
                f"{self.rows}, {self.columns}, {self.pitch} m"
            )
        if not 0 <= self.friction < np.inf:
            raise InputError(f"friction must be >= 0, got {self.friction}")


@dataclass(frozen=True)
class PressureTable:
    """Pressure over depth in even steps, for kernels; extrapolated linearly."""

    step: float
    """Depth between two entries, m."""
    pressures: NDArray[np.float64]
    """(TABLE_SIZE,), Pa, the first at depth 0."""


def pressure_table(pad: Foam, touched: Foam | None = None) -> PressureTable:
    """Tabulate the pressure over the depth of an object's surface in the pad's foam.

    Parameters
    ----------
    pad
        The pad's foam.
    touched
        Material of the object, as a layer of foam; rigid if not given. Both layers bear the same
        pressure, and their compressions add up to the depth.

    Returns
    -------
    PressureTable
        Table from depth 0 to the depth at which the pad's foam is solid.
    """
    if touched is None:
        depths = np.linspace(0.0, pad.hard_depth, TABLE_SIZE)
        return PressureTable(depths[1], pad.pressure(depths))
    rising = np.geomspace(_MIN_TABLE_PRESSURE, pad.hard_pressure, _INVERSION_POINTS)
    pressures = np.concatenate([[0.0], rising])
    reached = pad.compression(pressures) + touched.compression(pressures)
    depths = np.linspace(0.0, reached[-1], TABLE_SIZE)
    return PressureTable(depths[1], np.interp(depths, reached, pressures))

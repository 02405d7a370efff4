"""A tactile image: what every tactel of an array feels, and where it sits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class TactileArray:
    """Geometry of a tactile array: flat pads, curved patches and fingertips are lists of tactels.

    Raises
    ------
    InputError
        If shapes disagree or the area is not positive.
    """

    positions: NDArray[np.float64]
    """Tactel centres in the sensor's frame, (N, 3), m; z points towards the object."""
    normals: NDArray[np.float64]
    """Unit outward normals, (N, 3)."""
    area: float
    """Sensitive area of one tactel, m²."""
    neighbours: NDArray[np.bool_]
    """Which tactels touch one another, (N, N)."""

    def __post_init__(self) -> None:
        count = len(self.positions)
        if self.positions.shape != (count, 3) or self.normals.shape != (count, 3):
            raise InputError(
                f"positions and normals must be (N, 3), got {self.positions.shape} and "
                f"{self.normals.shape}"
            )
        if self.neighbours.shape != (count, count):
            raise InputError(f"neighbours must be ({count}, {count}), got {self.neighbours.shape}")
        if not self.area > 0:
            raise InputError(f"tactel area must be > 0 m², got {self.area}")

    @classmethod
    def flat(cls, rows: int = 16, columns: int = 16, pitch: float = 0.005) -> TactileArray:
        """Give a flat pad centred on the sensor's origin, tactels row by row; pitch in m."""
        if rows < 1 or columns < 1 or not pitch > 0:
            raise InputError(
                f"a pad needs rows, columns, pitch > 0, got {rows}, {columns}, {pitch}"
            )
        v, u = np.mgrid[0:rows, 0:columns]
        x = (u.ravel() - 0.5 * (columns - 1)) * pitch
        y = (v.ravel() - 0.5 * (rows - 1)) * pitch
        positions = np.column_stack([x, y, np.zeros(rows * columns)])
        normals = np.tile([0.0, 0.0, 1.0], (rows * columns, 1))
        gaps = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
        return cls(positions, normals, pitch**2, (gaps > 0) & (gaps < 1.5 * pitch))


@dataclass(frozen=True)
class TactileImage:
    """Calibrated pressures of one moment.

    Raises
    ------
    InputError
        If there is not one finite pressure per tactel.
    """

    pressures: NDArray[np.float64]
    """Pressure on each tactel, (N,), Pa."""
    array: TactileArray
    """Where the tactels are."""

    def __post_init__(self) -> None:
        count = len(self.array.positions)
        if self.pressures.shape != (count,) or not np.all(np.isfinite(self.pressures)):
            raise InputError(f"pressures must be {count} finite values, got {self.pressures.shape}")

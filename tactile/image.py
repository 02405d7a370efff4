"""Tactile arrays and the pressures that they measure."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from eyehand.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

FINGER_RADIUS = 0.008
"""Radius of the fingertip's cylinder and of the hemisphere at its end, m, as of a person."""
FINGER_PITCH = 0.005
"""Distance between rows of the fingertip, m."""
FINGER_SPREAD = np.radians(50.0)
"""Angle between columns of the fingertip, around its axis, and between its last straight row and
the row on the hemisphere, rad."""
OPEN_GAP = np.radians(120.0)
"""Gap between the directions of a tactel's neighbours, rad, from which it is on the border. Inside
a grid the gap is at most 90°, along a straight edge 180°, along a round end a little less."""
UNIT_TOLERANCE = 1e-6
"""Maximum error of a unit normal's length, due to files with few digits."""


@dataclass(frozen=True)
class TactileArray:
    """Geometry of a tactile array: a flat pad, a curved patch or a fingertip, as a list of tactels.

    Raises
    ------
    InputError
        If shapes disagree, something is not finite, normals are not unit vectors, areas are not
        positive, or the neighbours are not mutual.
    """

    positions: NDArray[np.float64]
    """Tactel centres in the sensor's frame, (N, 3), m. The z-axis points towards the object."""
    normals: NDArray[np.float64]
    """Unit outward normals, (N, 3)."""
    area: float
    """Sensitive area of one tactel, m²; the mean if they differ."""
    neighbours: NDArray[np.bool_]
    """Symmetric mask of adjacent tactels, (N, N)."""
    areas: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    """Sensitive area of each tactel, (N,), m². By default, all have `area`."""
    grid: tuple[int, int] | None = None
    """Rows (along y) and columns of an even grid, in this order; None for other arrays."""

    def __post_init__(self) -> None:
        count = len(self.positions)
        if self.areas.size == 0:
            object.__setattr__(self, "areas", np.full(count, float(self.area)))
        if self.positions.shape != (count, 3) or self.normals.shape != (count, 3):
            raise InputError(
                f"positions and normals must be (N, 3), got {self.positions.shape} and "
                f"{self.normals.shape}"
            )
        if self.neighbours.shape != (count, count):
            raise InputError(f"neighbours must be ({count}, {count}), got {self.neighbours.shape}")
        if not np.array_equal(self.neighbours, self.neighbours.T):
            raise InputError("neighbours must be mutual, got a matrix that is not symmetric")
        if self.areas.shape != (count,):
            raise InputError(f"areas must be ({count},), got {self.areas.shape}")
        if not (0 < self.area < np.inf and self.areas.min(initial=np.inf) > 0):
            raise InputError(f"tactel area must be > 0 m², got {self.area}")
        if not np.isclose(self.areas.mean(), self.area):
            raise InputError(f"area must be the mean {self.areas.mean()} of areas, got {self.area}")
        lengths = np.linalg.norm(self.normals, axis=1)
        if not (np.isfinite(self.positions).all() and (abs(lengths - 1) < UNIT_TOLERANCE).all()):
            raise InputError("positions must be finite and normals must be unit vectors")
        if self.grid is not None and self.grid[0] * self.grid[1] != count:
            raise InputError(f"a grid must have {count} tactels, got {self.grid} rows and columns")

    @classmethod
    def flat(cls, rows: int = 16, columns: int = 16, pitch: float = 0.005) -> TactileArray:
        """Return a flat pad centred on the sensor's origin, tactels row by row; pitch in m."""
        u, v = _even_grid(rows, columns, pitch)
        positions = np.column_stack([u, v, np.zeros(len(u))])
        normals = np.tile([0.0, 0.0, 1.0], (len(u), 1))
        links = _grid_neighbours(rows, columns)
        return cls(positions, normals, pitch**2, links, grid=(rows, columns))

    @classmethod
    def curved(
        cls, rows: int = 16, columns: int = 16, pitch: float = 0.005, radius: float = 0.05
    ) -> TactileArray:
        """Return a patch of a cylinder along x, with its top at the sensor's origin; lengths in m.

        The rows are `pitch` apart along the arc around the cylinder.

        Raises
        ------
        InputError
            If the patch covers more than half a cylinder.
        """
        if not (0 < radius < np.inf and rows * pitch <= np.pi * radius):
            raise InputError(
                f"a curved pad must cover at most half a cylinder, got radius {radius} m for "
                f"{rows} rows of pitch {pitch} m"
            )
        u, v = _even_grid(rows, columns, pitch)
        around = v / radius
        normals = np.column_stack([np.zeros(len(u)), np.sin(around), np.cos(around)])
        positions = np.column_stack([u, radius * normals[:, 1], radius * (normals[:, 2] - 1.0)])
        links = _grid_neighbours(rows, columns)
        return cls(positions, normals, pitch**2, links, grid=(rows, columns))

    @classmethod
    def fingertip(cls) -> TactileArray:
        """Return a fingertip with 12 tactels: three straight rows of three, and one on its end.

        The finger is along y, with its end at +y. The sensor's origin is the middle of the
        straight part, on the surface.
        """
        row, column = (index.ravel() for index in np.mgrid[0:4, 0:3])
        around, over = (column - 1) * FINGER_SPREAD, (row == 3) * FINGER_SPREAD
        along = (np.minimum(row, 2) - 1) * FINGER_PITCH
        normals = np.column_stack(
            [np.cos(over) * np.sin(around), np.sin(over), np.cos(over) * np.cos(around)]
        )
        positions = FINGER_RADIUS * normals
        positions += np.column_stack([0 * along, along, np.full(12, -FINGER_RADIUS)])
        straight = FINGER_RADIUS * FINGER_SPREAD * FINGER_PITCH
        # The zone of a sphere from half a step below the row's latitude to half a step above it.
        zone = np.sin(1.5 * FINGER_SPREAD) - np.sin(0.5 * FINGER_SPREAD)
        areas = np.where(row == 3, FINGER_RADIUS**2 * FINGER_SPREAD * zone, straight)
        return cls(positions, normals, float(areas.mean()), _grid_neighbours(4, 3), areas)

    @cached_property
    def border(self) -> NDArray[np.bool_]:
        """Mask of the tactels on the border, (N,)."""
        return np.array([self._is_on_border(tactel) for tactel in range(len(self.positions))])

    @cached_property
    def links(self) -> NDArray[np.int32]:
        """Neighbour lists in one array, (N + 1 + L,), for the compiled kernels.

        First the start of each tactel's list, then the end of the last one, then all lists.
        """
        counts = self.neighbours.sum(axis=1)
        starts = len(counts) + 1 + np.concatenate([[0], np.cumsum(counts)])
        return np.concatenate([starts, np.nonzero(self.neighbours)[1]]).astype(np.int32)

    @cached_property
    def geometry(self) -> NDArray[np.float64]:
        """Position (3), normal (3), area, and 1 on the border, of each tactel, (N, 8)."""
        border = self.border.astype(np.float64)
        return np.column_stack([self.positions, self.normals, self.areas, border])

    def _is_on_border(self, tactel: int) -> bool:
        """Return whether the directions of the neighbours leave a wide gap, seen from above."""
        offsets = self.positions[self.neighbours[tactel]] - self.positions[tactel]
        if len(offsets) < 2:
            return True
        x, y = tangents(self.normals[tactel]) @ offsets.T
        angles = np.sort(np.arctan2(y, x))
        gaps = np.diff(angles, append=angles[0] + 2 * np.pi)
        return bool(gaps.max() >= OPEN_GAP)


@dataclass(frozen=True)
class TactileImage:
    """Calibrated pressures of all tactels at one time.

    Raises
    ------
    InputError
        If there is not one finite pressure per tactel.
    """

    pressures: NDArray[np.float64]
    """Pressure on each tactel, (N,), Pa."""
    array: TactileArray
    """Geometry of the tactels."""

    def __post_init__(self) -> None:
        count = len(self.array.positions)
        if self.pressures.shape != (count,) or not np.all(np.isfinite(self.pressures)):
            raise InputError(f"pressures must be {count} finite values, got {self.pressures.shape}")


def tangents(normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the tangent plane's axes (2, 3): x and y, rotated as z is to `normal`.

    On a flat pad these are x and y themselves. For the normal -z, that rotation is not unique; the
    axes are then x and -y.
    """
    a, b, c = normal
    if c <= -1.0 + 1e-12:
        return np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    d = 1.0 / (1.0 + c)
    return np.array([[1.0 - a * a * d, -a * b * d, -a], [-a * b * d, 1.0 - b * b * d, -b]])


def _even_grid(
    rows: int, columns: int, pitch: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return coordinates along columns and rows, (N,) each, centred on 0, m."""
    if rows < 1 or columns < 1 or not 0 < pitch < np.inf:
        raise InputError(f"rows, columns and pitch must be > 0, got {rows}, {columns}, {pitch}")
    v, u = np.mgrid[0:rows, 0:columns]
    return (
        (u.ravel() - 0.5 * (columns - 1)) * pitch,
        (v.ravel() - 0.5 * (rows - 1)) * pitch,
    )


def _grid_neighbours(rows: int, columns: int) -> NDArray[np.bool_]:
    """Return the mask of tactels that share a side or a corner, (N, N)."""
    v, u = (index.ravel() for index in np.mgrid[0:rows, 0:columns])
    apart = np.maximum(abs(v[:, None] - v), abs(u[:, None] - u))
    return apart == 1

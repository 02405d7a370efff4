"""Tactile arrays and the pressures that they measure."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from eyehand.errors import InputError

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
MAX_TACTEL_AREA, MAX_ARRAY_REACH = 0.01, 1.0
"""Maximum area of a tactel, m², and distance of a tactel from the sensor's origin, m. The tactels
of pads, hands and robot skins have 0.1 to 20 cm². Lengths in mm exceed both."""
UNIT_TOLERANCE = 1e-6
"""Maximum error of a unit normal's length, due to files with few digits."""


@dataclass(frozen=True)
class TactileArray:
    """Geometry of a tactile array: a flat pad, a curved patch or a fingertip, as a list of tactels.

    Raises
    ------
    InputError
        If shapes disagree, something is not finite, normals are not unit vectors, areas are not
        positive, or a pair of neighbours is wrong.
    """

    positions: NDArray[np.float64] = field(repr=False)
    """Tactel centres in the sensor's frame, (N, 3), m. The z-axis points towards the object."""
    normals: NDArray[np.float64] = field(repr=False)
    """Unit outward normals, (N, 3)."""
    area: float
    """Sensitive area of one tactel, m²; the mean if they differ."""
    neighbours: NDArray[np.int32] = field(repr=False)
    """Pairs of adjacent tactels, (L, 2), each pair once."""
    areas: NDArray[np.float64] = field(default_factory=lambda: np.empty(0), repr=False)
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
        _check_pairs(self.neighbours, count)
        if self.areas.shape != (count,):
            raise InputError(f"areas must be ({count},), got {self.areas.shape}")
        if not (0 < self.area < np.inf and self.areas.min(initial=np.inf) > 0):
            raise InputError(f"tactel area must be > 0 m², got {self.area}")
        if self.areas.max() > MAX_TACTEL_AREA:
            raise InputError(
                f"tactel area must be at most {MAX_TACTEL_AREA:g} m², got {self.areas.max():g}: "
                "pitch and positions must be in m"
            )
        if abs(self.positions).max() > MAX_ARRAY_REACH:
            raise InputError(
                f"tactels must be within {MAX_ARRAY_REACH:g} m of the sensor's origin, got "
                f"{abs(self.positions).max():g} m: positions must be in m"
            )
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

    @classmethod
    def of_poses(
        cls,
        positions: NDArray[np.float64],
        normals: NDArray[np.float64],
        areas: NDArray[np.float64] | float,
        reach: float,
    ) -> TactileArray:
        """Return an array of any shape; tactels within `reach` of each other are neighbours.

        Parameters
        ----------
        positions, normals
            Of each tactel in the sensor's frame, (N, 3), m, and unit vectors outwards.
        areas
            Sensitive area of each tactel, (N,), or of all, m².
        reach
            Maximum distance of neighbours, m: about 1.5 times the distance of the tactels.

        Raises
        ------
        InputError
            If a value is wrong, see :class:`TactileArray`, or the reach is not positive.
        """
        if not 0 < reach < np.inf or not np.isfinite(positions).all():
            raise InputError(f"reach must be > 0 m and positions finite, got reach {reach}")
        pairs = KDTree(positions).query_pairs(reach, output_type="ndarray").astype(np.int32)
        each = np.broadcast_to(np.asarray(areas, np.float64), (len(positions),)).copy()
        return cls(positions, normals, float(each.mean()), pairs, each)

    @cached_property
    def border(self) -> NDArray[np.bool_]:
        """Mask of the tactels on the border, (N,).

        There, the directions of the neighbours leave a wide gap, seen along the normal.
        """
        start, end = self._both_ways
        axes = tangents(self.normals)
        offsets = self.positions[end] - self.positions[start]
        x, y = np.einsum("lij,lj->il", axes[start], offsets)
        angles = np.arctan2(y, x)
        order = np.lexsort((angles, start))
        start, angles = start[order], angles[order]
        counts = np.bincount(start, minlength=len(self.positions))
        firsts = np.cumsum(counts) - counts
        # The gap after the last direction of a tactel ends at its first one, a turn later.
        following = np.append(angles[1:], 0.0)
        lasts = (firsts + counts - 1)[counts > 0]
        following[lasts] = angles[firsts[counts > 0]] + 2 * np.pi
        border = counts < 2
        border[start[following - angles >= OPEN_GAP]] = True
        return border

    @cached_property
    def links(self) -> NDArray[np.int32]:
        """Neighbour lists in one array, (N + 1 + L,), for the compiled kernels.

        First the start of each tactel's list, then the end of the last one, then all lists.
        """
        start, end = self._both_ways
        counts = np.bincount(start, minlength=len(self.positions))
        starts = len(counts) + 1 + np.concatenate([[0], np.cumsum(counts)])
        return np.concatenate([starts, end[np.lexsort((end, start))]]).astype(np.int32)

    @cached_property
    def geometry(self) -> NDArray[np.float64]:
        """Position (3), normal (3), area, and 1 on the border, of each tactel, (N, 8)."""
        border = self.border.astype(np.float64)
        return np.column_stack([self.positions, self.normals, self.areas, border])

    @property
    def _both_ways(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Each pair from both sides: the tactel and its neighbour, (2 L,) each."""
        a, b = self.neighbours.T
        return np.concatenate([a, b]), np.concatenate([b, a])


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


def tangents(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the axes (..., 2, 3) of tangent planes: x and y, rotated as z is to `normals`.

    On a flat pad these are x and y themselves. For the normal -z, that rotation is not unique; the
    axes are then x and -y.
    """
    a, b, c = np.moveaxis(normals, -1, 0)
    back = c <= -1.0 + 1e-12
    d = 1.0 / np.where(back, 1.0, 1.0 + c)
    axes = [[1.0 - a * a * d, -a * b * d, -a], [-a * b * d, 1.0 - b * b * d, -b]]
    opposite = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    return np.where(back[..., None, None], opposite, np.moveaxis(np.array(axes), (0, 1), (-2, -1)))


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


def _grid_neighbours(rows: int, columns: int) -> NDArray[np.int32]:
    """Return the pairs of tactels that share a side or a corner, (L, 2)."""
    number = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    sides = [(number[:, :-1], number[:, 1:]), (number[:-1], number[1:])]
    corners = [(number[:-1, :-1], number[1:, 1:]), (number[:-1, 1:], number[1:, :-1])]
    return np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in sides + corners])


def _check_pairs(pairs: NDArray[np.int32], count: int) -> None:
    """Raise an `InputError` unless the pairs (L, 2) name each two tactels at most once."""
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.dtype.kind not in "iu":
        raise InputError(
            f"neighbours must be pairs of tactels, (L, 2) integers, got {pairs.shape} {pairs.dtype}"
        )
    low, high = pairs.min(axis=1).astype(np.int64), pairs.max(axis=1).astype(np.int64)
    if len(pairs) and (low.min() < 0 or high.max() >= count or (low == high).any()):
        raise InputError(f"neighbours must be two different tactels in 0..{count - 1}")
    if len(np.unique(low * count + high)) < len(pairs):
        raise InputError("each pair of neighbours must occur once")

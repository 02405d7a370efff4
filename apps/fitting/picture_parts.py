"""The plain data of a picture: light to load, so that a child process draws it without delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class View:
    """One side to look from, orthographically."""

    name: str
    """front, side or top."""
    right: NDArray[np.float64]
    """Direction that is right in the picture, (3,)."""
    up: NDArray[np.float64]
    """Direction that is up in the picture, (3,)."""

    @property
    def towards(self) -> NDArray[np.float64]:
        """Direction towards the viewer, (3,)."""
        return np.cross(self.right, self.up)

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (..., 3) in the picture's plane, (..., 2), m."""
        return np.stack([points @ self.right, points @ self.up], axis=-1)


@dataclass(frozen=True)
class PictureScene:
    """Everything that is drawn, relative to the middle of the picture, m."""

    points: NDArray[np.float64]
    """(N, 3), far ones left out."""
    colours: NDArray[np.float64]
    """(N, 3) RGB, 0-1: blue inside the solid, red outside, grey on it."""
    facing: NDArray[np.float64]
    """(N, 3) outward unit normals of the solid next to the points; 0 without a solid."""
    limit_mm: float
    """Distance at which the colours end; 0 without a solid."""
    surfaces: tuple[tuple[NDArray[np.float64], NDArray[np.int64]], ...]
    """Vertices (V, 3) and faces (T, 3) of each solid."""
    curves: tuple[NDArray[np.float64], ...]
    """Feature lines, (K, 3) each."""
    normals: tuple[NDArray[np.float64], ...]
    """Outward unit normals along them, (K, 3) each."""
    views: tuple[View, View, View]
    """Front, side, top."""
    half: float
    """Half the side of every view, m."""

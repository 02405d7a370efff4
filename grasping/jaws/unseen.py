"""Space that objects hide from the camera: a finger that enters it may meet something unseen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from ..hands import ParallelHand
    from .candidates import Candidates
    from .surface_model import ObjectSurface

CELL = 0.014
"""Side of a cell of directions, rad: the distance of averaged points at 0.6 m, 8 mm."""
BEHIND = 0.015
"""Distance behind a visible point from which a place is hidden, m."""


_Place = tuple["NDArray[np.int64]", "NDArray[np.float64]"]
"""Cells of directions from the camera, (2, n), and distances from it, (n,), m."""


class HiddenSpace:
    """The space that the objects of a scene hide from the camera.

    Parameters
    ----------
    surfaces
        Surfaces of all objects; their measured points hide what is behind them.
    view_origin
        Position of the camera, (3,), m.
    hand
        The hand.
    """

    def __init__(
        self,
        surfaces: Sequence[ObjectSurface],
        view_origin: NDArray[np.float64],
        hand: ParallelHand,
    ) -> None:
        measured = [surface.points[: surface.measured] for surface in surfaces]
        self._owner = np.concatenate([np.full(len(part), k) for k, part in enumerate(measured)])
        self._places, self._palm = _finger_places(hand), _palm_places(hand)
        self._origin = view_origin
        if len(self._owner) == 0:
            return
        points = np.concatenate(measured) - view_origin
        self._frame = _frame(points.mean(axis=0))
        cells, self._ranges = _cells(points, self._frame)
        self._low = cells.min(axis=0) - 1
        self._size = cells.max(axis=0) + 2 - self._low
        self._index = (cells - self._low) @ [self._size[1], 1]
        self._images: dict[int, NDArray[np.float64]] = {}

    def shares(
        self, candidates: Candidates, opening: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the shares of each finger's tip that others and only the own object hide, (n, 2).

        The second one is at least that of the front of the palm.

        Parameters
        ----------
        candidates
            Candidates of one object.
        opening
            Distance between the pads, (n,), m.
        """
        count, places = len(candidates), self._places
        if len(self._owner) == 0 or count == 0:
            return np.zeros((count, 2)), np.zeros((count, 2))
        fingers = np.tile(places, (count, 2, 1, 1))
        fingers[..., 0] += 0.5 * opening[:, None, None]
        fingers[:, 1, :, 0] *= -1.0
        palm = np.broadcast_to(self._palm, (count, *self._palm.shape))
        local = np.concatenate([fingers.reshape(count, -1, 3), palm], axis=1)
        world = local @ candidates.rotation.transpose(0, 2, 1) + candidates.tip[:, None]
        place = self._places_seen(world.reshape(-1, 3))
        others = self._covered(place, int(candidates.object[0]))
        own = self._covered(place, -1) & ~others
        others, own = others.reshape(count, -1), own.reshape(count, -1)
        tips, each = 2 * len(places), (count, 2, -1)
        before_palm = own[:, tips:].mean(axis=1, keepdims=True)
        behind = np.maximum(own[:, :tips].reshape(each).mean(axis=2), before_palm)
        return others[:, :tips].reshape(each).mean(axis=2), behind

    def hides(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (n, 3), m, any object hides, (n,)."""
        if len(self._owner) == 0 or len(points) == 0:
            return np.zeros(len(points), bool)
        return self._covered(self._places_seen(points), -1)

    def _places_seen(self, points: NDArray[np.float64]) -> _Place:
        """Return where the camera sees points (n, 3)."""
        where, distance = _cells(points - self._origin, self._frame)
        return np.clip(where - self._low, 0, self._size - 1).T, distance

    def _covered(self, place: _Place, number: int) -> NDArray[np.bool_]:
        """Return which places objects hide, except that with the number, (n,)."""
        (row, column), distance = place
        return self._image(number)[row, column] < distance - BEHIND

    def _image(self, number: int) -> NDArray[np.float64]:
        """Return the ranges of the other objects' points in cells of directions, m."""
        if number not in self._images:
            image = np.full(self._size[0] * self._size[1], np.inf)
            others = self._owner != number
            np.minimum.at(image, self._index[others], self._ranges[others])
            self._images[number] = _grown(image.reshape(self._size))
        return self._images[number]


def _finger_places(hand: ParallelHand) -> NDArray[np.float64]:
    """Return places in the tip of the finger at +x at opening 0, (k, 3), m."""
    thick = max(box.high[0] for box in hand.finger_boxes if box.high[2] > -hand.pad_height / 2)
    half = 0.5 * hand.pad_width
    grid = np.meshgrid([0.0, thick], [-half, half], [0.0, -0.5 * hand.pad_height])
    return np.stack(grid, axis=-1).reshape(-1, 3)


def _palm_places(hand: ParallelHand) -> NDArray[np.float64]:
    """Return places in front of the palm and between the open fingers, (k, 3), m."""
    across = 0.5 * hand.stroke * np.array([-0.5, 0.0, 0.5])
    return np.stack([across, np.zeros(3), np.full(3, -hand.finger_depth)], axis=1)


def _frame(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a rotation (3, 3) whose last row is along an axis."""
    forward = axis / np.linalg.norm(axis)
    right = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(forward, right), forward], dtype=np.float64)


def _cells(
    points: NDArray[np.float64], frame: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the cells (n, 2) of the directions of points (n, 3), and their distances (n,), m."""
    local = points @ frame.T
    distance = np.linalg.norm(local, axis=1)
    angles = np.arctan2(local[:, :2], np.maximum(local[:, 2:], 1e-9))
    return np.floor(angles / CELL).astype(np.int64), distance


def _grown(image: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the image with single empty cells filled from their neighbours."""
    padded = np.full((image.shape[0] + 2, image.shape[1] + 2), np.inf)
    padded[1:-1, 1:-1] = image
    across = np.maximum(padded[1:-1, :-2], padded[1:-1, 2:])
    along = np.maximum(padded[:-2, 1:-1], padded[2:, 1:-1])
    return np.minimum(image, np.minimum(across, along))

"""Heights at which a hand clears the walls and the content of the tray while it releases an object.

The hand is lowered without turning, opens, and rises. So the lowest point of the open hand in each
vertical column decides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .hand_clearance import hand_boxes
from .hands import HandModel, ParallelHand

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from .prototypes import Prototype
    from .tray import Tray
    from .tray_plan import TrayItem

CELL = 0.005
"""Side of the square columns, m."""
BEYOND = 0.3
"""Width of the columns beyond the tray, m. A hand that holds an object from the side reaches as
far."""
POINT_STEP = 0.01
"""Maximum distance of neighbouring points in a box of the hand, m."""
SIDE_MARGIN = 0.008
"""Horizontal distance kept from walls and content, m. It covers the error of their positions."""
OVER_MARGIN = 0.005
"""Vertical distance kept from them, m."""
OPENINGS = 4
"""Number of openings from the held to the open jaws. Their boxes overlap or lie close together."""


class Columns(NamedTuple):
    """Heights of walls and content above the tray's floor, grown by `SIDE_MARGIN`."""

    corner: NDArray[np.float64]
    """Centre of the first column, (2,), world, m."""
    tops: NDArray[np.float64]
    """Height of each column, (X, Y), m."""

    def heights(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the heights (...) of the columns at points (..., 2), world, m."""
        index = np.rint((points - self.corner) / CELL).astype(np.int64)
        x, y = np.moveaxis(np.clip(index, 0, np.array(self.tops.shape) - 1), -1, 0)
        heights: NDArray[np.float64] = self.tops[x, y]
        return heights


def tray_columns(tray: Tray, content: Sequence[TrayItem]) -> Columns:
    """Return the heights of the walls and of all content."""
    half = 0.5 * np.asarray(tray.size)
    count = np.ceil((half + BEYOND) / CELL).astype(int)
    x, y = (CELL * np.arange(-n, n + 1) for n in count)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    beyond = (np.abs(grid) - half).max(axis=-1)
    wall = (beyond > -SIDE_MARGIN) & (beyond < tray.wall_thickness + SIDE_MARGIN)
    tops = np.where(wall, tray.wall_height, 0.0)
    middle = tray.centre[:2]
    for item in content:
        apart = np.linalg.norm(grid + middle - item.place, axis=-1)
        tops = np.where(apart < item.radius + SIDE_MARGIN, np.maximum(tops, item.top), tops)
    return Columns(middle - CELL * count, tops)


def opening_boxes(
    hand: HandModel | ParallelHand, prototype: Prototype, width: float
) -> NDArray[np.float64]:
    """Return corners (B, 2, 3), m, of boxes around a hand that opens from a width, in its frame."""
    if isinstance(hand, HandModel):
        return hand_boxes(hand, prototype, hand.max_opening, width)
    jaws = [
        hand.jaw_boxes(opening) + hand.middle(opening)
        for opening in np.linspace(width, hand.stroke, OPENINGS)
    ]
    return np.concatenate([*jaws, hand.fixed_boxes()])


def lowest_points(
    boxes: NDArray[np.float64], axes: NDArray[np.float64], centre: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the lowest point of boxes in each column, (P, 3), m.

    Parameters
    ----------
    boxes
        Corners in the hand's frame, (B, 2, 3), m.
    axes
        Rotation from the hand's frame to the world, (3, 3).
    centre
        Point in the hand's frame that becomes the origin, (3,), m.
    """
    clouds = []
    for low, high in boxes:
        counts = np.maximum(np.ceil((high - low) / POINT_STEP).astype(int), 1) + 1
        sides = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
        clouds.append(np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3))
    points = (np.concatenate(clouds) - centre) @ axes.T
    points = points[np.argsort(points[:, 2])]
    _, first = np.unique(np.rint(points[:, :2] / CELL), axis=0, return_index=True)
    return points[first]


def clear_heights(
    columns: Columns, points: NDArray[np.float64], places: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the lowest height of the held point over each place (G, 2), (G,), m.

    There the hand clears walls and content. Heights are above the tray's floor.

    Parameters
    ----------
    columns
        Heights of walls and content.
    points
        Lowest points of the hand, from the held point, (P, 3), world axes, m.
    places
        Positions of the held point, (G, 2), world, m.
    """
    under = columns.heights(places[:, None] + points[:, :2])
    heights: NDArray[np.float64] = (under - points[:, 2]).max(axis=1) + OVER_MARGIN
    return heights

"""Objects whose ridges, edges and corners are to be found by touch, and where these truly are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from eyehand.data_synth.pad import Part, TouchObject, box_edge

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

THICK = 0.02
"""Half the height of things with a flat top, m."""
BOX = (0.075, 0.055)
"""Half sides of the box, m: larger than the pad, which lands where it feels no edge."""
RIDGE = 0.14
"""Length of the ridge, m."""
PRISM_RADIUS, PRISM_SIDES = 0.075, 5
"""From a prism's axis to its upright edges, m, and how many it has: they turn by 72°."""
BEND_LONG, BEND_WIDE = 0.13, 0.075
"""Length and width of the bend's two arms, m."""
BEND_LANDING = 0.015
"""From the middle of where the arms meet to where the pad lands, along both, m: so that the arm
reaches all of it."""
DISC_RADIUS = 0.065
"""m."""


@dataclass(frozen=True)
class SeekShape:
    """An object with a flat top, or a ridge, at z = 0 of its own frame."""

    thing: TouchObject
    """What stands in the cell."""
    outline: NDArray[np.float64]
    """(N, 2), m: the top's rim from above, closed; a ridge's two ends."""
    corners: NDArray[np.float64]
    """(C, 2), m: all places worth finding; none where the rim has no corner."""
    middle: tuple[float, float] = (0.0, 0.0)
    """Where on it the pad lands, m."""

    @property
    def name(self) -> str:
        """What it is called."""
        return self.thing.name

    @cached_property
    def _segments(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        closed = len(self.outline) > 2
        ends = np.roll(self.outline, -1, axis=0) if closed else self.outline[1:]
        return self.outline[: len(ends)], ends

    def nearest(self, place: NDArray[np.float64], *, corner: bool) -> NDArray[np.float64]:
        """Give the true corner, or point of the rim, that is nearest to a place, (2,), m."""
        if corner and len(self.corners):
            return self.corners[np.argmin(np.linalg.norm(self.corners - place, axis=1))]
        begin, end = self._segments
        way = end - begin
        share = ((place - begin) * way).sum(axis=1) / (way**2).sum(axis=1)
        points = begin + np.clip(share, 0.0, 1.0)[:, None] * way
        return points[np.argmin(np.linalg.norm(points - place, axis=1))]


def box() -> SeekShape:
    """Give a box, 150 x 110 mm."""
    x, y = BOX
    corners = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
    return SeekShape(TouchObject("box", (_block(x, y),)), corners, corners)


def ridge() -> SeekShape:
    """Give a sharp ridge, 140 mm long."""
    ends = 0.5 * RIDGE * np.array([[1.0, 0.0], [-1.0, 0.0]])
    return SeekShape(TouchObject("ridge", box_edge(RIDGE).parts), ends, ends)


def prism() -> SeekShape:
    """Give a prism with five corners."""
    turn = 2.0 * np.pi * np.arange(PRISM_SIDES) / PRISM_SIDES
    corners = PRISM_RADIUS * np.column_stack([np.cos(turn), np.sin(turn)])
    side = float(np.linalg.norm(corners[1] - corners[0]))
    apothem = PRISM_RADIUS * np.cos(np.pi / PRISM_SIDES)
    # Its angles are over 90°: a block inwards of each side stays within, and all fill it.
    parts = tuple(
        _block(0.5 * apothem, 0.5 * side, 0.5 * apothem, 0.0, angle + np.pi / PRISM_SIDES)
        for angle in turn
    )
    return SeekShape(TouchObject("prism", parts), corners, corners)


def bend() -> SeekShape:
    """Give a right-angled bend, which has a corner that turns outwards."""
    a, b = BEND_LONG, BEND_WIDE
    corners = np.array([[0, 0], [a, 0], [a, b], [b, b], [b, a], [0, a]]) - 0.5 * b
    parts = (
        _block(0.5 * a, 0.5 * b, 0.5 * (a - b), 0.0),
        _block(0.5 * b, 0.5 * a, 0.0, 0.5 * (a - b)),
    )
    return SeekShape(TouchObject("bend", parts), corners, corners, (BEND_LANDING, BEND_LANDING))


def disc() -> SeekShape:
    """Give a disc: a rim without a corner."""
    part = Part("cylinder", (DISC_RADIUS, THICK), (0.0, 0.0, -THICK))
    turn = np.linspace(0.0, 2.0 * np.pi, 181)[:-1]
    outline = DISC_RADIUS * np.column_stack([np.cos(turn), np.sin(turn)])
    return SeekShape(TouchObject("disc", (part,)), outline, np.zeros((0, 2)))


SHAPES: dict[str, Callable[[], SeekShape]] = {
    "box": box,
    "ridge": ridge,
    "prism": prism,
    "bend": bend,
    "disc": disc,
}
"""All of them by name."""


def _block(
    half_x: float, half_y: float, along: float = 0.0, across: float = 0.0, turn: float = 0.0
) -> Part:
    """Give a block of a flat top, its middle at (along, across), all turned about z."""
    about = Rotation.from_euler("z", turn)
    x, y, z = about.apply([along, across, -THICK]).tolist()
    qw, qx, qy, qz = about.as_quat(scalar_first=True).tolist()
    return Part("box", (half_x, half_y, THICK), (x, y, z), (qw, qx, qy, qz))

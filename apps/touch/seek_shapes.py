"""Objects for the search of ridges, edges and corners by touch, with their ground truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from eyehand.data_synth.pad import Part, TouchObject, box_edge

THICK = 0.02
"""Half the height of objects with a flat top, m."""
BOX = (0.075, 0.055)
"""Half side lengths of the box, m. The box is larger than the pad, which lands away from edges."""
RIDGE = 0.14
"""Length of the ridge, m."""
PRISM_RADIUS, PRISM_SIDES = 0.075, 5
"""Distance from the prism's axis to its vertical edges, m, and number of these edges."""
BEND_LONG, BEND_WIDE = 0.13, 0.075
"""Length and width of the two arms of the bend, m."""
BEND_LANDING = 0.015
"""Offset of the landing point from the centre of the joint along both arms of the bend, m. With it,
the robot arm reaches the whole object."""
DISC_RADIUS = 0.065
"""Radius of the disc, m."""


@dataclass(frozen=True)
class SeekShape:
    """An object with its flat top or ridge at z = 0 of the object frame."""

    touch_object: TouchObject
    """Object in the simulation."""
    outline: NDArray[np.float64]
    """Closed rim (N, 2) of the top from above, or the two ends of a ridge, m."""
    corners: NDArray[np.float64]
    """True corners or ends (C, 2), m. Empty for a rim without corners."""
    middle: tuple[float, float] = (0.0, 0.0)
    """Landing point of the pad on the object, m."""

    @property
    def name(self) -> str:
        """Name of the object."""
        return self.touch_object.name

    @cached_property
    def _segments(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        closed = len(self.outline) > 2
        ends = np.roll(self.outline, -1, axis=0) if closed else self.outline[1:]
        return self.outline[: len(ends)], ends

    def nearest(self, place: NDArray[np.float64], *, corner: bool) -> NDArray[np.float64]:
        """Return the true corner, or the point of the rim, closest to a position (2,), m."""
        if corner and len(self.corners):
            return self.corners[np.argmin(np.linalg.norm(self.corners - place, axis=1))]
        begin, end = self._segments
        side = end - begin
        fraction = ((place - begin) * side).sum(axis=1) / (side**2).sum(axis=1)
        points = begin + np.clip(fraction, 0.0, 1.0)[:, None] * side
        return points[np.argmin(np.linalg.norm(points - place, axis=1))]


def box() -> SeekShape:
    """Return a box of 150 x 110 mm."""
    x, y = BOX
    corners = np.array([[x, y], [-x, y], [-x, -y], [x, -y]])
    return SeekShape(TouchObject("box", (_block(x, y),)), corners, corners)


def ridge() -> SeekShape:
    """Return a sharp ridge with a length of 140 mm."""
    ends = 0.5 * RIDGE * np.array([[1.0, 0.0], [-1.0, 0.0]])
    return SeekShape(TouchObject("ridge", box_edge(RIDGE).parts), ends, ends)


def prism() -> SeekShape:
    """Return a prism with five corners."""
    turn = 2.0 * np.pi * np.arange(PRISM_SIDES) / PRISM_SIDES
    corners = PRISM_RADIUS * np.column_stack([np.cos(turn), np.sin(turn)])
    side = float(np.linalg.norm(corners[1] - corners[0]))
    apothem = PRISM_RADIUS * np.cos(np.pi / PRISM_SIDES)
    # All angles exceed 90°. A block inwards of each side stays inside, and together they fill it.
    parts = tuple(
        _block(0.5 * apothem, 0.5 * side, 0.5 * apothem, 0.0, angle + np.pi / PRISM_SIDES)
        for angle in turn
    )
    return SeekShape(TouchObject("prism", parts), corners, corners)


def bend() -> SeekShape:
    """Return a right-angled bend with one inner corner."""
    a, b = BEND_LONG, BEND_WIDE
    corners = np.array([[0, 0], [a, 0], [a, b], [b, b], [b, a], [0, a]]) - 0.5 * b
    parts = (
        _block(0.5 * a, 0.5 * b, 0.5 * (a - b), 0.0),
        _block(0.5 * b, 0.5 * a, 0.0, 0.5 * (a - b)),
    )
    return SeekShape(TouchObject("bend", parts), corners, corners, (BEND_LANDING, BEND_LANDING))


def disc() -> SeekShape:
    """Return a disc, with a rim without corners."""
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
"""Functions that build the shapes, by name."""


def _block(
    half_x: float, half_y: float, along: float = 0.0, across: float = 0.0, turn: float = 0.0
) -> Part:
    """Return a block with its centre at (along, across), rotated about z by `turn`."""
    about = Rotation.from_euler("z", turn)
    x, y, z = about.apply([along, across, -THICK]).tolist()
    qw, qx, qy, qz = about.as_quat(scalar_first=True).tolist()
    return Part("box", (half_x, half_y, THICK), (x, y, z), (qw, qx, qy, qz))

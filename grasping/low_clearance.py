"""Grips that need less room: turned, shallower, off the middle."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from eyehand.perception import Superquadric

    from .grasp_geometry import Grip
    from .palm_placement import GraspDepths

DIRECTIONS = 8
"""Closing directions over half a turn that are tried on what has no flat sides to close on."""
WIDER = 1.25
"""Width beside the narrowest up to which such a direction counts: farther off, the fingers turn
the object before they hold it."""
OFF_MIDDLE = 0.22
"""Shares of the length by which a long object is held off its middle."""
LONG = 0.050
"""Length from which that is worth while, m."""
STRAIGHT = ("box", "cylinder", "superquadric", "tapered")
"""Kinds that are about as wide off their middle as in it."""
SHALLOW_SIDES = 0.013
"""How far tips reach below a flat top where there is no room for more, m."""
SHALLOW_MIDDLE = 0.003
"""How far the ends of the tips then pass the middle of what is round, m."""


def roomier(
    grip: Grip, solid: Superquadric, narrowest: float, depths: GraspDepths
) -> Iterator[tuple[Grip, GraspDepths, float]]:
    """Give other ways to take hold from above, each with its depths and what it is worth, 0-1.

    Parameters
    ----------
    grip
        A grip from above; one of several for what is not round.
    solid
        What is held.
    narrowest
        Its smallest horizontal width, m.
    depths
        The usual depths; the first of the two given for each grip.

    Returns
    -------
    iterator of tuple
        All fixed in orientation. Worth falls off the middle, with shallow holds and
        with width.
    """
    for place, worth in _places(grip, solid, narrowest):
        yield place, depths, worth
        yield place, _shallow(place, depths), 0.8 * worth


def _places(grip: Grip, solid: Superquadric, narrowest: float) -> Iterator[tuple[Grip, float]]:
    for closing in _closings(grip, solid):
        level = _turned(grip, solid, closing)
        if level.width > WIDER * max(narrowest, grip.width):
            continue
        worth = float(min(grip.width / level.width, 1.0)) ** 2
        yield level, worth
        if grip.kind in STRAIGHT and level.length > LONG and level.width < level.length:
            for share in (-OFF_MIDDLE, OFF_MIDDLE):
                aside = level.centre + share * level.length * level.axis
                yield replace(level, centre=aside, length=level.length), 0.7 * worth


def _closings(grip: Grip, solid: Superquadric) -> list[NDArray[np.float64]]:
    if solid.kind in ("box", "cylinder") and grip.freedom == "none":
        return [grip.closing]
    across = np.cross(grip.up, grip.closing)
    if grip.freedom == "none":
        # The other pair of sides has a grip of its own: to half of the way there.
        angles = np.arange(-DIRECTIONS // 4 + 1, DIRECTIONS // 4 + 1) * np.pi / DIRECTIONS
    else:
        angles = np.arange(2 * DIRECTIONS) * np.pi / DIRECTIONS
    return [np.cos(angle) * grip.closing + np.sin(angle) * across for angle in angles]


def _turned(grip: Grip, solid: Superquadric, closing: NDArray[np.float64]) -> Grip:
    axis = np.cross(grip.palm, closing)
    spans = solid.support(np.array([closing, axis])) + solid.support(-np.array([closing, axis]))
    return replace(
        grip,
        freedom="none",
        closing=closing,
        axis=axis,
        width=float(spans[0]),
        length=float(spans[1]),
    )


def _shallow(grip: Grip, depths: GraspDepths) -> GraspDepths:
    # A superquadric may be round below a face that looks flat.
    if grip.flat and grip.kind != "superquadric":
        return replace(depths, tip_depth=SHALLOW_SIDES, tip_beyond=-float("inf"))
    return replace(depths, tip_depth=0.0, tip_beyond=SHALLOW_MIDDLE)

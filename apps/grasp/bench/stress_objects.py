"""Objects of the stress trials: a solid of given size somewhere in the work area, by seed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.scenes import TabletopObject
from eyehand.perception.superquadric import Superquadric

if TYPE_CHECKING:
    from eyehand.perception.superquadric import Kind

EXPONENTS: dict[Kind, tuple[float, float]] = {
    "box": (0.1, 0.1),
    "cylinder": (0.1, 1.0),
    "ellipsoid": (1.0, 1.0),
    "sphere": (1.0, 1.0),
}
"""Of the superquadric that stands for each."""
AROUND = 0.06
"""How far from the middle of the table objects stand, along either axis, m."""
MASS = 0.2
"""Where weight is not the question, kg."""
COLOUR = (0.75, 0.45, 0.25)
"""Of all of them."""
LYING = Rotation.from_rotvec([0.5 * np.pi, 0.0, 0.0])
"""Turns a solid's z-axis into the level."""


def somewhere(seed: int) -> tuple[np.ndarray, Rotation]:
    """Draw a place on the table, (2,), m, and a turn about the vertical."""
    rng = np.random.default_rng([seed, 21])
    return rng.uniform(-AROUND, AROUND, 2), Rotation.from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)])


def standing(
    kind: Kind,
    size: tuple[float, float, float],
    seed: int,
    *,
    mass: float = MASS,
    place: tuple[float, float] | np.ndarray | None = None,
    name: str = "",
    lying: bool = False,
    aside: tuple[float, float] = (0.0, 0.0),
) -> TabletopObject:
    """Put a solid on the table.

    Parameters
    ----------
    kind, size
        Which solid, and its full extents along its own axes, m.
    seed
        Of its place and its turn about the vertical.
    mass
        kg.
    place
        Where its middle stands instead, m.
    name
        Its name; the kind when not given.
    lying
        Whether its z-axis is level.
    aside
        How far it stands from there along its own x and y as turned, m.
    """
    at, turn = somewhere(seed)
    if place is not None:
        at = np.asarray(place, dtype=np.float64)
    half = 0.5 * np.asarray(size)
    height = half[1] if lying else half[2]
    offset = turn.apply([*aside, 0.0])[:2]
    pose = RigidTransform.from_components([*(at + offset), height], turn * LYING if lying else turn)
    shape = Superquadric(half, EXPONENTS[kind], pose, kind)
    return TabletopObject(name or kind, shape, mass, COLOUR)

"""Objects of the stress trials: solids of a given size at random positions."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.scenes import TabletopObject
from eyehand.perception.superquadric import Kind, Superquadric

EXPONENTS: dict[Kind, tuple[float, float]] = {
    "box": (0.1, 0.1),
    "cylinder": (0.1, 1.0),
    "ellipsoid": (1.0, 1.0),
    "sphere": (1.0, 1.0),
}
"""Superquadric exponents of each kind of solid."""
MAX_OFFSET = 0.06
"""Maximum distance of an object from the centre of the table along x and y, m."""
DEFAULT_MASS = 0.2
"""Mass of an object unless the sweep is about weight, kg."""
COLOUR = (0.75, 0.45, 0.25)
"""Colour of all objects, RGB in [0, 1]."""
LYING = Rotation.from_rotvec([0.5 * np.pi, 0.0, 0.0])
"""Rotation that makes the z axis of a solid horizontal."""


def object_on_table(
    kind: Kind,
    size: tuple[float, float, float],
    seed: int,
    *,
    mass: float = DEFAULT_MASS,
    position: tuple[float, float] | np.ndarray | None = None,
    name: str = "",
    lying: bool = False,
    offset: tuple[float, float] = (0.0, 0.0),
) -> TabletopObject:
    """Place a solid on the table.

    Parameters
    ----------
    kind, size
        Kind of the solid, and its full extents along its own axes, m.
    seed
        Seed of the position and of the rotation about the vertical.
    mass
        Mass, kg.
    position
        Position (2,) of the centre instead of a random one, m.
    name
        Name of the object; default: the kind.
    lying
        Whether the z axis of the solid is horizontal.
    offset
        Offset from the position along the rotated x and y axes, m.
    """
    rng = np.random.default_rng([seed, 21])
    centre = rng.uniform(-MAX_OFFSET, MAX_OFFSET, 2)
    rotation = Rotation.from_rotvec([0, 0, rng.uniform(-np.pi, np.pi)])
    if position is not None:
        centre = np.asarray(position, dtype=np.float64)
    half = 0.5 * np.asarray(size)
    centre = centre + rotation.apply([*offset, 0.0])[:2]
    height = half[1] if lying else half[2]
    pose = RigidTransform.from_components(
        [*centre, height], rotation * LYING if lying else rotation
    )
    shape = Superquadric(half, EXPONENTS[kind], pose, kind)
    return TabletopObject(name or kind, shape, mass, COLOUR)


def can_on_table(
    seed: int, mass: float = DEFAULT_MASS, position: np.ndarray | None = None
) -> TabletopObject:
    """Place a can of 60 mm, which every hand should hold."""
    size = (0.06, 0.06, 0.11)
    return object_on_table("cylinder", size, seed, mass=mass, position=position, name="can")

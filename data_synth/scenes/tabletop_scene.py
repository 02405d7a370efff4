"""A table with objects at rest and a camera over it: the ground truth of one synthetic view."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from eyehand.perception import CameraIntrinsics
    from eyehand.perception.superquadric import Kind, Superquadric

Family = Literal["separate", "touching", "stacked", "dropped", "piled"]
"""How the objects stand to one another."""


@dataclass(frozen=True)
class Table:
    """A rectangular table top whose centre lies over the world's origin."""

    size: tuple[float, float] = (1.2, 0.8)
    """Extent along world x and y, m."""
    height: float = 0.0
    """World z of the top, m."""
    floor_drop: float = 0.72
    """How far the floor lies below the top, m."""


@dataclass(frozen=True)
class TabletopObject:
    """One rigid object.

    Its solid is exact for the kind: a box has sharp edges, although the superquadric that
    stands for it has exponents just above 0 (the corner of that superquadric lies 1.1 % of the
    half diagonal inside the box's).
    """

    name: str
    """Kind and number in the scene, ``box_3``."""
    shape: Superquadric
    """Semi-axes, exponents and kind; `pose` maps shape coordinates to the world."""
    mass: float
    """kg."""
    colour: tuple[float, float, float]
    """Red, green, blue, each in [0, 1]."""

    @property
    def kind(self) -> Kind:
        """Which solid it is."""
        return self.shape.kind

    def at(self, T_world_shape: RigidTransform) -> TabletopObject:
        """Return the same object with its shape frame at another place."""
        return replace(self, shape=replace(self.shape, pose=T_world_shape))


@dataclass(frozen=True)
class TabletopScene:
    """Objects at rest on a table, seen by one camera."""

    seed: int
    """What it was drawn from."""
    family: Family
    """How the objects stand to one another."""
    objects: tuple[TabletopObject, ...]
    """Label k of a rendered view is object k-1."""
    table: Table
    """What they stand on."""
    intrinsics: CameraIntrinsics
    """The camera."""
    T_world_camera: RigidTransform
    """Maps camera coordinates (x right, y down, z forward) to the world."""


def solid_volume(shape: Superquadric) -> float:
    """Volume in m³ of the solid that the kind names, with sharp edges where it has some."""
    box = 8.0 * float(np.prod(shape.semi_axes))
    filled = {"box": 1.0, "cylinder": np.pi / 4, "sphere": np.pi / 6, "ellipsoid": np.pi / 6}
    return box * filled[shape.kind] if shape.kind in filled else shape.volume

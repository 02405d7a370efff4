"""Ground truth of one synthetic view: a table, objects at rest, and a camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from scipy.spatial.transform import RigidTransform

    from eyehand.perception import CameraIntrinsics
    from eyehand.perception.superquadric import Kind, Superquadric

Family = Literal["separate", "touching", "stacked", "dropped", "piled"]
"""Arrangement of the objects."""


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

    The solid is exact for its kind: a box has sharp edges. The superquadric that describes it has
    exponents just above 0, and its corner lies 1.1 % of the half diagonal inside the box's.
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
        """Kind of solid."""
        return self.shape.kind

    def at(self, T_world_shape: RigidTransform) -> TabletopObject:
        """Return the same object with another pose."""
        return replace(self, shape=replace(self.shape, pose=T_world_shape))


@dataclass(frozen=True)
class TabletopScene:
    """Objects at rest on a table, seen by one camera."""

    seed: int
    """Seed of the scene."""
    family: Family
    """Arrangement of the objects."""
    objects: tuple[TabletopObject, ...]
    """Label k of a rendered view is object k-1."""
    table: Table
    """The table."""
    intrinsics: CameraIntrinsics
    """The camera."""
    T_world_camera: RigidTransform
    """Maps camera coordinates (x right, y down, z forward) to the world."""


def solid_volume(shape: Superquadric) -> float:
    """Return the volume of the exact solid of a kind, m³."""
    box = 8.0 * float(np.prod(shape.semi_axes))
    filled = {"box": 1.0, "cylinder": np.pi / 4, "sphere": np.pi / 6, "ellipsoid": np.pi / 6}
    return box * filled[shape.kind] if shape.kind in filled else shape.volume

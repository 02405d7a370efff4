"""Ground truth of one view of objects in and on furniture."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

from .fixture import Fixture, add_fixture
from .mesh_object import MeshObject, add_mesh_object
from .object_folder import FolderObject
from .tabletop_options import ViewOptions, check_range
from .tabletop_scene import TabletopObject
from .tabletop_spec import add_lighting, add_solid, new_spec

FurnishedFamily = Literal["bin", "tote", "shelf", "tray", "clutter", "small-table"]
"""Furniture and arrangement of a scene. ``bin`` and ``tote``: objects scattered or heaped in a
container with upright or leaning walls. ``tray``: in a tray with a rim of 10 to 30 mm and beside
it. ``shelf``: on boards between walls. ``clutter``: touching and leaning on a table in a room.
``small-table``: on a table of 0.15 m to 0.5 m above a visible floor."""

_SLICES = 56
"""Facets of round parts beside an arm: a 120 mm ball is exact to 0.1 mm."""

RigidObject = TabletopObject | MeshObject

COUNT_RANGES: dict[FurnishedFamily, tuple[int, int]] = {
    "bin": (4, 24),
    "tote": (5, 20),
    "shelf": (3, 12),
    "tray": (3, 9),
    "clutter": (8, 20),
    "small-table": (1, 4),
}
"""Default numbers of objects."""
MAX_FURNISHED_OBJECTS = 40
"""Maximum number of objects: settling takes seconds for more."""


@dataclass(frozen=True)
class FurnishedOptions:
    """Options of :func:`make_furnished_scene`.

    Raises
    ------
    InputError
        If a range is reversed or a value is out of its bounds.
    """

    family: FurnishedFamily = "bin"
    """Furniture and arrangement."""
    count_range: tuple[int, int] | None = None
    """Minimum and maximum number of objects; 0 leaves the furniture empty. None takes
    `COUNT_RANGES`, and more in bins whose floor is hidden. Objects that fall off the furniture are
    removed, so there may be fewer."""
    meshes: tuple[FolderObject, ...] = ()
    """Objects from files, used in place of random solids."""
    mesh_share: float = 1.0
    """Probability that an object is one of `meshes`, if there are any."""
    arm: bool = False
    """Whether a robot arm reaches into the scene."""
    image_size: tuple[int, int] = ViewOptions().image_size
    """Columns and rows, px."""

    def __post_init__(self) -> None:
        if self.count_range is not None:
            check_range("count_range", self.count_range, 0, MAX_FURNISHED_OBJECTS, "objects")
        if not 0 <= self.mesh_share <= 1:
            raise InputError(f"mesh_share must lie in [0, 1], got {self.mesh_share}")
        ViewOptions(image_size=self.image_size)

    @property
    def counts(self) -> tuple[int, int]:
        """Minimum and maximum number of objects."""
        return COUNT_RANGES[self.family] if self.count_range is None else self.count_range


@dataclass(frozen=True)
class FurnishedScene:
    """Objects at rest in and on furniture, seen by one camera."""

    seed: int
    """Seed of the scene."""
    family: FurnishedFamily
    """Furniture and arrangement."""
    objects: tuple[RigidObject, ...]
    """Label k of a rendered view is object k-1."""
    fixtures: tuple[Fixture, ...] = field(repr=False)
    """The furniture and its surroundings."""
    intrinsics: CameraIntrinsics
    """The camera."""
    T_world_camera: RigidTransform
    """Maps camera coordinates (x right, y down, z forward) to the world."""


def object_pose(item: RigidObject) -> RigidTransform:
    """Return T_world_object."""
    return item.pose if isinstance(item, MeshObject) else item.shape.pose


def object_reach(item: RigidObject) -> float:
    """Return a bound of the distance of an object's points from its origin, m."""
    return (
        item.radius if isinstance(item, MeshObject) else float(np.linalg.norm(item.shape.semi_axes))
    )


def fixture_name(number: int) -> str:
    """Return the name of a fixture's geom."""
    return f"fixture_{number}"


def furnished_spec(
    objects: tuple[RigidObject, ...], fixtures: tuple[Fixture, ...], *, free: bool
) -> Any:
    """Describe objects and fixtures as an `MjSpec`; the objects' bodies come first.

    Parameters
    ----------
    objects, fixtures
        Parts of the scene. A geom of an object has its name, that of a fixture `fixture_name`.
    free
        Give the objects a free joint (for physics) or fix them and add light (for rendering).
    """
    spec = new_spec()
    if not free:
        add_lighting(spec, 0.0)
        if any(item.kind == "robot" for item in fixtures):
            # An arm has 50 round parts, which take seconds to draw with more facets.
            spec.visual.quality.numslices, spec.visual.quality.numstacks = _SLICES, _SLICES // 2
    else:
        spec.add_material(name="object")
    for item in objects:
        if isinstance(item, MeshObject):
            add_mesh_object(spec, item, free=free)
        else:
            add_solid(spec, item, free=free, visuals=not free)
    for number, item in enumerate(fixtures):
        add_fixture(spec, fixture_name(number), item, visuals=not free)
    return spec

"""Objects that are lowered into furniture one by one and come to rest there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import CameraIntrinsics

from .fixture import Fixture
from .furnished_scene import RigidObject, fixture_name, furnished_spec, object_reach
from .furnished_settings import DropZone
from .household_shapes import rest_rotation
from .mesh_object import MeshObject
from .rigid_physics import RigidPhysics

MAX_SETTLE_S = 4.0
"""Maximum simulated time to come to rest after the last object has fallen."""
REST_SPEED_M_S = 0.005
"""Objects are at rest if none of their points is faster. A ball in a heap may rock more slowly for
seconds."""
KEPT_MARGIN_M = 0.06
"""Objects that come to rest farther than this outside their zone are removed."""

_SPOTS = 12
"""Positions tried for one object before it is left out."""
_STEP_M = 0.006
"""Step by which an object is lowered until it would touch."""
_NEAR_M = 0.001
"""Distances are computed up to this value to find overlaps."""
_PAUSE_S, _SHORT_PAUSE_S = 0.35, 0.15
"""Maximum time before the next object falls, for few objects and for a crowd."""
_CROWD = 24
"""More objects than this are a crowd, whose steps take long."""


class FurnishedPhysics(RigidPhysics):
    """Free objects between fixtures."""

    def __init__(self, objects: Sequence[RigidObject], fixtures: Sequence[Fixture]) -> None:
        """Create the bodies of the objects."""
        spec = furnished_spec(tuple(objects), tuple(fixtures), free=True)
        reach = [object_reach(item) for item in objects]
        super().__init__(spec, [item.name for item in objects], reach)
        self._fixtures = [self._model.geom(fixture_name(k)).id for k in range(len(fixtures))]

    def top(self, index: int) -> float:
        """Return a bound of an object's highest point, world z, m."""
        return float(self.pose(index).translation[2] + self._reach[index])

    def visible_parts(
        self, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Count the pixels of each object and of each fixture in a camera's image."""
        counts = self._visible_geoms(intrinsics, T_world_camera)
        return counts[self._geom], counts[self._fixtures]

    def fixtures_touch(self, some: Sequence[int], ignored: Sequence[int]) -> bool:
        """Return whether some fixtures overlap an object or a fixture that is not ignored."""
        mine = [self._fixtures[k] for k in some]
        left_out = {self._fixtures[k] for k in (*some, *ignored)}
        others = [*self._geom, *(geom for geom in self._fixtures if geom not in left_out)]
        return any(
            self._mujoco.mj_geomDistance(self._model, self._data, one, other, _NEAR_M, None) <= 0
            for one in mine
            for other in others
        )

    def touches(self, index: int) -> bool:
        """Return whether an object overlaps anything where it is."""
        self._mujoco.mj_collision(self._model, self._data)
        return bool(np.any(self._data.contact.geom == self._geom[index]))


def pour(
    objects: Sequence[RigidObject],
    zones: Sequence[DropZone],
    physics: FurnishedPhysics,
    rng: np.random.Generator,
) -> tuple[RigidObject, ...] | str:
    """Let objects fall one after the other, and remove those that do not stay in their zone.

    Parameters
    ----------
    objects
        The objects, in the order of the simulation.
    zones
        Places for them, with weights.
    physics
        The simulation.
    rng
        Source of randomness.

    Returns
    -------
    tuple of RigidObject, or str
        The objects that stayed, at rest; or why there is no such state.
    """
    shares = np.array([zone.share for zone in zones])
    chosen = rng.choice(len(zones), size=len(objects), p=shares / shares.sum())
    pause = _SHORT_PAUSE_S if len(objects) > _CROWD else _PAUSE_S
    placed: dict[int, DropZone] = {}
    for index, item in enumerate(objects):
        zone = zones[chosen[index]]
        if _release(index, item, zone, physics, list(placed), rng):
            placed[index] = zone
            physics.settle(pause)
    for _ in range(2):
        physics.settle(MAX_SETTLE_S)
        if physics.unstable:
            return "unstable physics"
        gone = [k for k, zone in placed.items() if not _stays(physics.pose(k), zone)]
        if not gone:
            break
        # What leaned on a removed object settles again.
        physics.park(gone)
        placed = {k: zone for k, zone in placed.items() if k not in gone}
    else:
        return "off the furniture"
    if physics.max_speed() > REST_SPEED_M_S:
        return "never at rest"
    return tuple(objects[k].at(physics.pose(k)) for k in placed)


def _release(
    index: int,
    item: RigidObject,
    zone: DropZone,
    physics: FurnishedPhysics,
    others: Sequence[int],
    rng: np.random.Generator,
) -> bool:
    """Lower an object over a free spot until it almost touches; return False if none is free."""
    for _ in range(_SPOTS):
        rotation = _orientation(item, rng, upright=rng.random() < zone.upright)
        low, high = _vertical_extent(item, rotation)
        spot = zone.T_world_zone.apply([*(rng.uniform(-1, 1, 2) * zone.half), 0.0])
        ceiling = zone.headroom - (high - low)
        top = max((physics.top(k) for k in others), default=spot[2]) - spot[2]
        height = min(max(top, zone.start) + 2 * _STEP_M, ceiling - _STEP_M)
        if height <= 0:
            continue
        position = spot + np.array([0.0, 0.0, height - low])
        physics.put(index, RigidTransform.from_components(position, rotation))
        if physics.touches(index):
            continue
        while not physics.touches(index) and position[2] > spot[2] - low - _STEP_M:
            position[2] -= _STEP_M
            physics.move(index, position)
        position[2] += _STEP_M
        physics.move(index, position)
        return True
    physics.park([index])
    return False


def _stays(pose: RigidTransform, zone: DropZone) -> bool:
    return bool(zone.holds(pose.translation[None], KEPT_MARGIN_M)[0])


def _orientation(item: RigidObject, rng: np.random.Generator, *, upright: bool) -> Rotation:
    if not upright:
        return Rotation.random(rng=rng)
    if isinstance(item, MeshObject):
        return Rotation.from_euler("Z", rng.uniform(-np.pi, np.pi))
    return rest_rotation(item.shape, rng, upright=False)


def _vertical_extent(item: RigidObject, rotation: Rotation) -> tuple[float, float]:
    """Return the lowest and highest z of a turned object relative to its origin, m."""
    if isinstance(item, MeshObject):
        z = rotation.apply(item.vertices)[:, 2]
        return float(z.min()), float(z.max())
    up = rotation.inv().apply([0.0, 0.0, 1.0])
    # Solids are symmetric.
    half = float(item.shape.support(up))
    return -half, half

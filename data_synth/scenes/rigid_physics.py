"""Physics of rigid objects in a fixed world: placing, measuring distances, settling."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.perception import CameraIntrinsics

from ..mujoco_import import import_mujoco
from .tabletop_spec import VISIBLE_GROUPS

QUIET_SPEED_M_S = 1e-3
"""An object is quiet if none of its points is faster than this."""
QUIET_TIME_S = 0.24
"""Objects that are quiet for this long are at rest."""

_CHECK_INTERVAL_S = 0.03
_NO_SLIP_PASSES = 3
_PARKING_M = 50.0
_GAP_HORIZON_M = 10.0


class RigidPhysics:
    """State of a set of objects in MuJoCo; each is parked far away until it is placed."""

    def __init__(
        self, spec: Any, names: Sequence[str], reach: ArrayLike, *, no_creep: bool = False
    ) -> None:
        """Compile the world.

        Parameters
        ----------
        spec
            `MjSpec` of the world. Its first bodies are the objects, each with a free joint and one
            geom of its name.
        names
            Names of the objects, in the order of their bodies.
        reach
            Maximum distance of a point of each object from its origin, (n,), m.
        no_creep
            Compute friction without creep, which takes 10 % to 50 % more time. Otherwise tilted
            objects slide by 0.1 mm/s and may fall after seconds.
        """
        self._mujoco = import_mujoco()
        self._model = spec.compile()
        if no_creep:
            self._model.opt.noslip_iterations = _NO_SLIP_PASSES
        self._data = self._mujoco.MjData(self._model)
        self._count = len(names)
        self._geom = [self._model.geom(name).id for name in names]
        self._reach = np.asarray(reach, dtype=np.float64)
        self._parked: set[int] = set()
        self.park(range(self._count))
        self._mujoco.mj_kinematics(self._model, self._data)

    def park(self, indices: Iterable[int]) -> None:
        """Move objects far away, where they stay until they are placed."""
        self._parked.update(indices)
        for index in indices:
            self._data.qvel[6 * index : 6 * index + 6] = 0.0
            self.move(index, np.array([_PARKING_M, index, _PARKING_M]))

    def put(self, index: int, T_world_shape: RigidTransform) -> None:
        """Place object `index` at a pose, with zero velocity."""
        self._parked.discard(index)
        turn = T_world_shape.rotation.as_quat(scalar_first=True)
        self._data.qpos[7 * index + 3 : 7 * index + 7] = turn
        self._data.qvel[6 * index : 6 * index + 6] = 0.0
        self.move(index, T_world_shape.translation)

    def move(self, index: int, position: NDArray[np.float64]) -> None:
        """Shift object `index` so that its shape frame's origin lies at `position` (3,), m."""
        self._data.qpos[7 * index : 7 * index + 3] = position
        self._mujoco.mj_kinematics(self._model, self._data)

    def pose(self, index: int) -> RigidTransform:
        """Return T_world_shape of object `index`."""
        qpos = self._data.qpos[7 * index : 7 * index + 7]
        rotation = Rotation.from_quat(qpos[3:], scalar_first=True)
        return RigidTransform.from_components(qpos[:3], rotation)

    def gap(self, one: int, other: int) -> float:
        """Return the distance between two objects, m; negative if they overlap."""
        return self._distance(self._geom[one], self._geom[other])

    def nearest_gap(self, index: int, others: Sequence[int]) -> float:
        """Return the distance from an object to the nearest of others, m; infinite if none."""
        return min((self.gap(index, other) for other in others), default=np.inf)

    def settle(self, max_time: float) -> bool:
        """Simulate until all objects are at rest; return False if not within `max_time`, s."""
        step = self._model.opt.timestep
        batch = max(round(_CHECK_INTERVAL_S / step), 1)
        quiet = 0.0
        ends = self._data.time + max_time
        while self._data.time < ends and quiet < QUIET_TIME_S:
            self._step(batch)
            if self.unstable:
                return False
            quiet = quiet + batch * step if self.max_speed() < QUIET_SPEED_M_S else 0.0
        self._mujoco.mj_forward(self._model, self._data)
        return quiet >= QUIET_TIME_S

    def run(self, duration: float) -> None:
        """Simulate for `duration` s, with the pull of a bowl computed once at the start."""
        self._step(max(round(duration / self._model.opt.timestep), 1))
        self._mujoco.mj_forward(self._model, self._data)

    @property
    def unstable(self) -> bool:
        """Whether MuJoCo met a NaN or a huge acceleration, and reset the simulation."""
        kinds = self._mujoco.mjtWarning
        bad = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)
        return any(self._data.warning[int(kind)].number > 0 for kind in bad)

    def max_speed(self) -> float:
        """Return an upper bound of the speed of any point of an object, m/s; parked ones rest."""
        twist = self._data.qvel.reshape(self._count, 6)
        linear = np.linalg.norm(twist[:, :3], axis=1)
        angular = np.linalg.norm(twist[:, 3:], axis=1)
        return float(np.max(linear + angular * self._reach, initial=0.0))

    def visible_pixels(
        self, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform
    ) -> NDArray[np.intp]:
        """Count the pixels of each object in a camera's image, (n,).

        Geoms outside the visible groups hide nothing.
        """
        return self._visible_geoms(intrinsics, T_world_camera)[self._geom]

    def _visible_geoms(
        self, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform
    ) -> NDArray[np.intp]:
        """Count the pixels of each geom in a camera's image, (ngeom,)."""
        rays = intrinsics.rays().reshape(-1, 3) @ T_world_camera.rotation.as_matrix().T
        hit = np.full(len(rays), -1, dtype=np.int32)
        self._mujoco.mj_multiRay(
            self._model,
            self._data,
            np.array(T_world_camera.translation),
            np.ascontiguousarray(rays).reshape(-1),
            np.array(VISIBLE_GROUPS, dtype=np.uint8),
            1,
            -1,
            hit,
            np.empty(len(rays)),
            None,
            len(rays),
            self._mujoco.mjMAXVAL,
        )
        return np.bincount(hit[hit >= 0], minlength=self._model.ngeom)

    def _distance(self, geom: int, other: int) -> float:
        return self._mujoco.mj_geomDistance(
            self._model, self._data, geom, other, _GAP_HORIZON_M, None
        )

    def _step(self, count: int) -> None:
        self._mujoco.mj_step(self._model, self._data, count)
        if self._parked:
            self.park(self._parked.copy())

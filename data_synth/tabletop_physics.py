"""Rigid objects on a table under gravity: put down, measured, let come to rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from .mujoco_import import import_mujoco
from .tabletop_spec import VISIBLE_GROUPS, tabletop_spec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from eyehand.perception.frame import CameraIntrinsics

    from .tabletop_scene import Table, TabletopObject

QUIET_SPEED_M_S = 1e-3
"""An object none of whose points is faster than this is quiet."""
QUIET_TIME_S = 0.24
"""All objects quiet for so long are at rest."""

_CHECK_INTERVAL_S = 0.03
_PARKING_M = 50.0
_GAP_HORIZON_M = 10.0


class TabletopPhysics:
    """The state of a set of objects in MuJoCo; each is parked far away until it is put down."""

    def __init__(self, objects: Sequence[TabletopObject], table: Table) -> None:
        self._mujoco = import_mujoco()
        self._model = tabletop_spec(objects, table, free=True).compile()
        self._data = self._mujoco.MjData(self._model)
        self._count = len(objects)
        self._geom = [self._model.geom(item.name).id for item in objects]
        self._table = self._model.geom("table").id
        self._reach = np.array([np.linalg.norm(item.shape.semi_axes) for item in objects])
        self.park(range(self._count))

    def park(self, indices: Sequence[int] | range) -> None:
        """Take objects off the table."""
        for index in indices:
            self.move(index, np.array([_PARKING_M, index, _PARKING_M]))

    def put(self, index: int, T_world_shape: RigidTransform) -> None:
        """Place object `index`, at rest."""
        turn = T_world_shape.rotation.as_quat(scalar_first=True)
        self._data.qpos[7 * index + 3 : 7 * index + 7] = turn
        self._data.qvel[6 * index : 6 * index + 6] = 0.0
        self.move(index, T_world_shape.translation)

    def move(self, index: int, position: NDArray[np.float64]) -> None:
        """Shift object `index` so that its shape frame's origin lies at `position` (3,), m."""
        self._data.qpos[7 * index : 7 * index + 3] = position
        self._mujoco.mj_kinematics(self._model, self._data)

    def pose(self, index: int) -> RigidTransform:
        """Where object `index` is: T_world_shape."""
        qpos = self._data.qpos[7 * index : 7 * index + 7]
        rotation = Rotation.from_quat(qpos[3:], scalar_first=True)
        return RigidTransform.from_components(qpos[:3], rotation)

    def gap(self, one: int, other: int) -> float:
        """Distance between two objects, m; negative where they overlap."""
        return self._mujoco.mj_geomDistance(
            self._model, self._data, self._geom[one], self._geom[other], _GAP_HORIZON_M, None
        )

    def least_gap(self, index: int, others: Sequence[int]) -> float:
        """Distance from an object to the nearest of others, m; infinite when there are none."""
        return min((self.gap(index, other) for other in others), default=np.inf)

    def settle(self, longest: float) -> bool:
        """Let time run until all objects are at rest; False if they are not after `longest` s."""
        step = self._model.opt.timestep
        batch = max(round(_CHECK_INTERVAL_S / step), 1)
        quiet = 0.0
        while self._data.time < longest and quiet < QUIET_TIME_S:
            self._mujoco.mj_step(self._model, self._data, batch)
            quiet = quiet + batch * step if self.fastest() < QUIET_SPEED_M_S else 0.0
        self._mujoco.mj_forward(self._model, self._data)
        return quiet >= QUIET_TIME_S

    def run(self, duration: float) -> None:
        """Let time run for `duration` s."""
        self._mujoco.mj_step(
            self._model, self._data, max(round(duration / self._model.opt.timestep), 1)
        )
        self._mujoco.mj_forward(self._model, self._data)

    def fastest(self) -> float:
        """Bound on the speed of any point of any object, m/s."""
        twist = self._data.qvel.reshape(self._count, 6)
        linear = np.linalg.norm(twist[:, :3], axis=1)
        angular = np.linalg.norm(twist[:, 3:], axis=1)
        return float(np.max(linear + angular * self._reach))

    def on_table(self) -> set[int]:
        """Objects that touch the table."""
        pairs = self._data.contact.geom
        touching = {int(g) for pair in pairs if self._table in pair for g in pair}
        return {k for k, geom in enumerate(self._geom) if geom in touching}

    def seen_pixels(
        self, intrinsics: CameraIntrinsics, T_world_camera: RigidTransform
    ) -> NDArray[np.intp]:
        """Pixels in which a camera sees each object, (n,); the table hides nothing."""
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
        counts = np.bincount(hit[hit >= 0], minlength=self._model.ngeom)
        return counts[self._geom]

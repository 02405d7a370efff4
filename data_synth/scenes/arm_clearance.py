"""Distance of the 7-joint arm to the solids around it and between its own links."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arms import LBR_ARM, TOOL_SITE
from ..mujoco_import import import_mujoco

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from scipy.spatial.transform import RigidTransform


HORIZON_M = 1.0
"""Distances are computed up to this value."""

_JOINT_BODIES = ("link4", "link6")


class ReachingObstacle(NamedTuple):
    """A fixed solid that the arm must not touch."""

    name: str
    """Name, unique in the scene."""
    kind: str
    """Shape; always "box" so far."""
    size: tuple[float, float, float]
    """Half extents along the solid's own axes, m."""
    T_world_shape: RigidTransform
    """Pose; the arm's foot is the world's origin."""


class ArmClearance:
    """A MuJoCo model of the arm between fixed solids, for its smallest distance.

    The distance covers all moving links against all solids, and all pairs of links that the arm's
    file does not exclude. Geoms without collision are left out.
    """

    def __init__(self, obstacles: Sequence[ReachingObstacle] = ()) -> None:
        """Build the model.

        Parameters
        ----------
        obstacles
            Fixed solids; only kind "box".
        """
        self._mujoco = import_mujoco()
        self._model = arm_spec(obstacles).compile()
        self._data = self._mujoco.MjData(self._model)
        self._pairs = clearance_pairs(self._model)
        self._reach = self._model.geom_rbound[self._pairs].sum(axis=1)
        self._tool = self._model.site(TOOL_SITE).id
        self._joint_bodies = [self._model.body(name).id for name in _JOINT_BODIES]

    @property
    def joint_range(self) -> NDArray[np.float64]:
        """Lower and upper limits of the joints (2, 7), rad."""
        return self._model.jnt_range.T.copy()

    def at(self, q: NDArray[np.float64]) -> float:
        """Return the smallest distance at joint angles `q` (7,), m, <= 1; negative in overlap.

        The depth is exact until the middle line of a link enters a box, and approximate beyond.
        """
        self._move(q)
        middles = self._data.geom_xpos[self._pairs]
        bound = np.linalg.norm(middles[:, 0] - middles[:, 1], axis=1) - self._reach
        smallest = HORIZON_M
        for index in np.argsort(bound):
            if bound[index] >= smallest:
                break
            one, other = (int(geom) for geom in self._pairs[index])
            gap = self._mujoco.mj_geomDistance(self._model, self._data, one, other, HORIZON_M, None)
            smallest = min(smallest, gap)
        return float(smallest)

    def tool(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the tool's position at joint angles `q` (7,): (3,), world, m."""
        self._move(q)
        return self._data.site_xpos[self._tool].copy()

    def tool_axes(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the tool's rotation matrix at joint angles `q` (7,): (3, 3), tool to world."""
        self._move(q)
        return self._data.site_xmat[self._tool].reshape(3, 3).copy()

    def lowest_joint(self, q: NDArray[np.float64]) -> float:
        """Return the smallest height of elbow, wrist and tool at joint angles `q` (7,), m."""
        tool = self.tool(q)
        return float(min(tool[2], *self._data.xpos[self._joint_bodies, 2]))

    def _move(self, q: NDArray[np.float64]) -> None:
        self._data.qpos[:] = q
        self._mujoco.mj_kinematics(self._model, self._data)


def arm_spec(obstacles: Sequence[ReachingObstacle] = ()) -> Any:
    """Describe the arm with fixed solids around it.

    Parameters
    ----------
    obstacles
        Fixed solids; only kind "box". Each becomes a body and a geom of its name.

    Returns
    -------
    mujoco.MjSpec
        Not yet compiled, so that more can be added.

    Raises
    ------
    DeviceError
        If MuJoCo cannot be loaded.
    """
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(LBR_ARM))
    for item in obstacles:
        body = spec.worldbody.add_body(name=item.name)
        body.pos = item.T_world_shape.translation
        body.quat = item.T_world_shape.rotation.as_quat(scalar_first=True)
        body.add_geom(
            name=item.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=item.size,
            rgba=[0.62, 0.67, 0.73, 1.0],
        )
    return spec


def clearance_pairs(model: Any) -> NDArray[np.intp]:
    """List the pairs of geoms of a model that may touch: (P, 2) numbers, the lower one first.

    The list leaves out geoms without collision, pairs without relative motion, neighbours that
    share a joint, and pairs that the model excludes.
    """
    solid = np.flatnonzero(model.geom_contype | model.geom_conaffinity)
    excluded = {(int(sign) >> 16, int(sign) & 0xFFFF) for sign in model.exclude_signature}
    pairs = []
    for index, one in enumerate(solid):
        for other in solid[index + 1 :]:
            bodies = sorted((int(model.geom_bodyid[one]), int(model.geom_bodyid[other])))
            welds = [int(model.body_weldid[body]) for body in bodies]
            # The world is no neighbour: the first link can still hit solids fixed in the world.
            neighbours = 0 not in welds and (
                int(model.body_parentid[welds[1]]) == welds[0]
                or int(model.body_parentid[welds[0]]) == welds[1]
            )
            if welds[0] != welds[1] and not neighbours and tuple(bodies) not in excluded:
                pairs.append((one, other))
    return np.array(pairs, dtype=np.intp).reshape(-1, 2)

"""How far the 7-joint arm is from the solids around it and from itself, from joint angles alone."""

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
"""Gaps are told up to here; what is farther does not matter to anybody."""

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
    """A MuJoCo model of the arm amid solids that stand still, asked for its least gap.

    What counts: every shell of a link that moves against every solid, and every pair of shells
    that the arm's file does not exclude. Trim is left out.
    """

    def __init__(self, obstacles: Sequence[ReachingObstacle] = ()) -> None:
        """Build the model.

        Parameters
        ----------
        obstacles
            What stands around; only kind "box".
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
        """Least distance at joint angles `q` (7,), m: at most 1, negative where shapes overlap.

        A depth is exact until a shell's middle line enters a box; deeper, it is MuJoCo's guess.
        """
        self._move(q)
        middles = self._data.geom_xpos[self._pairs]
        bound = np.linalg.norm(middles[:, 0] - middles[:, 1], axis=1) - self._reach
        least = HORIZON_M
        for index in np.argsort(bound):
            if bound[index] >= least:
                break
            one, other = (int(geom) for geom in self._pairs[index])
            gap = self._mujoco.mj_geomDistance(self._model, self._data, one, other, HORIZON_M, None)
            least = min(least, gap)
        return float(least)

    def tool(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where the tool is at joint angles `q` (7,): (3,), world, m."""
        self._move(q)
        return self._data.site_xpos[self._tool].copy()

    def lowest_joint(self, q: NDArray[np.float64]) -> float:
        """Height of the lowest of elbow, wrist and tool at joint angles `q` (7,), m."""
        tool = self.tool(q)
        return float(min(tool[2], *self._data.xpos[self._joint_bodies, 2]))

    def _move(self, q: NDArray[np.float64]) -> None:
        self._data.qpos[:] = q
        self._mujoco.mj_kinematics(self._model, self._data)


def arm_spec(obstacles: Sequence[ReachingObstacle] = ()) -> Any:
    """Describe the arm with solids that stand still around it.

    Parameters
    ----------
    obstacles
        What stands around; only kind "box". Each becomes a body and a geom of its name.

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

    Left out: geoms without collision, pairs that do not move against each other, neighbours that
    share a joint, and pairs of bodies that the model excludes.
    """
    solid = np.flatnonzero(model.geom_contype | model.geom_conaffinity)
    excluded = {(int(sign) >> 16, int(sign) & 0xFFFF) for sign in model.exclude_signature}
    pairs = []
    for index, one in enumerate(solid):
        for other in solid[index + 1 :]:
            bodies = sorted((int(model.geom_bodyid[one]), int(model.geom_bodyid[other])))
            welds = [int(model.body_weldid[body]) for body in bodies]
            # The world is no neighbour: a link that turns on it can still hit what stands there.
            neighbours = 0 not in welds and (
                int(model.body_parentid[welds[1]]) == welds[0]
                or int(model.body_parentid[welds[0]]) == welds[1]
            )
            if welds[0] != welds[1] and not neighbours and tuple(bodies) not in excluded:
                pairs.append((one, other))
    return np.array(pairs, dtype=np.intp).reshape(-1, 2)

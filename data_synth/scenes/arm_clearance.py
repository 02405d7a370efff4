"""Distance of an arm to the solids around it and between its own links."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from eyehand.errors import InputError

from ..arms import HOME_KEY, ReachingArm
from ..mujoco_import import import_mujoco

HORIZON_M = 1.0
"""Distances are computed up to this value."""

INCLUDED = ReachingArm()
"""The included 7-joint arm."""
OBSTACLE_GROUP = 5
"""Group of the geoms that were added to the arm's file."""
SELF_MARGIN_M = 0.005
"""Two links nearer than this in the home posture are not measured: the hulls of some arms overlap
where their housings meet."""


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

    def __init__(
        self, obstacles: Sequence[ReachingObstacle] = (), arm: ReachingArm = INCLUDED
    ) -> None:
        """Build the model.

        Parameters
        ----------
        obstacles
            Fixed solids; only kind "box".
        arm
            The arm. Its joints that do not reach stay in the keyframe `home`.

        Raises
        ------
        InputError
            If the frame or a joint is not in the file.
        """
        self._mujoco = import_mujoco()
        self._model = model = arm_spec(obstacles, arm).compile()
        self._data = self._mujoco.MjData(model)
        self._data.qpos[:] = home_qpos(model)
        joints = joint_ids(model, arm)
        self._columns = model.jnt_qposadr[joints]
        self._ranges = model.jnt_range[joints].T.copy()
        self._second = joints[min(1, len(joints) - 1)]
        self._later_bodies = model.jnt_bodyid[joints[(len(joints) - 1) // 2 :]]
        self._origin, self._axes = frame_views(model, self._data, arm.frame)
        self._pairs = clearance_pairs(model)
        self._reach = model.geom_rbound[self._pairs].sum(axis=1)

    @property
    def joint_range(self) -> NDArray[np.float64]:
        """Lower and upper limits of the joints (2, n), rad."""
        return self._ranges.copy()

    def at(self, q: NDArray[np.float64]) -> float:
        """Return the smallest distance at joint angles `q` (n,), m, <= 1; negative in overlap.

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

    def move(self, name: str, place: NDArray[np.float64]) -> None:
        """Move a solid to a place (3,), world, m."""
        self._model.body(name).pos = place

    def tool(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the tool's position at joint angles `q` (n,): (3,), world, m."""
        self._move(q)
        return self._origin.copy()

    def tool_axes(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the tool's rotation matrix at joint angles `q` (n,): (3, 3), tool to world."""
        self._move(q)
        return self._axes.reshape(3, 3).copy()

    def lowest_joint(self, q: NDArray[np.float64]) -> float:
        """Return the smallest height of elbow, wrist and tool at joint angles `q` (n,), m.

        The joints from the middle of the chain on count.
        """
        tool = self.tool(q)
        return float(min(tool[2], *self._data.xpos[self._later_bodies, 2]))

    def reach(self, draws: int = 500) -> float:
        """Return the largest distance of the tool from the second joint in random postures, m."""
        rng = np.random.default_rng(0)
        anchor = self._model.jnt_bodyid[self._second]
        far = 0.0
        for q in rng.uniform(*self._ranges, size=(draws, len(self._columns))):
            far = max(far, float(np.linalg.norm(self.tool(q) - self._data.xpos[anchor])))
        return far

    def _move(self, q: NDArray[np.float64]) -> None:
        self._data.qpos[self._columns] = q
        self._mujoco.mj_kinematics(self._model, self._data)


def arm_spec(obstacles: Sequence[ReachingObstacle] = (), arm: ReachingArm = INCLUDED) -> Any:
    """Describe the arm with fixed solids around it, without visual meshes.

    Parameters
    ----------
    obstacles
        Fixed solids; only kind "box". Each becomes a body and a geom of its name.
    arm
        The arm.

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
    spec = mujoco.MjSpec.from_file(str(arm.file))
    spec.compiler.fusestatic = False
    _remove_visual_meshes(spec)
    for item in obstacles:
        body = spec.worldbody.add_body(name=item.name)
        body.pos = item.T_world_shape.translation
        body.quat = item.T_world_shape.rotation.as_quat(scalar_first=True)
        body.add_geom(
            name=item.name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=item.size,
            group=OBSTACLE_GROUP,
            rgba=[0.62, 0.67, 0.73, 1.0],
        )
    return spec


def _remove_visual_meshes(spec: Any) -> None:
    """Remove meshes that do not collide, because they take most of the time to compile."""
    for geom in list(spec.geoms):
        if geom.meshname and not (geom.contype or geom.conaffinity):
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) not in used:
            spec.delete(mesh)


def joint_ids(model: Any, arm: ReachingArm) -> NDArray[np.intp]:
    """Return the numbers (n,) of the arm's joints in a model.

    Raises
    ------
    InputError
        If a joint of the arm is not in the model.
    """
    known = {model.joint(joint).name: joint for joint in range(model.njnt)}
    for name in arm.joints:
        if name not in known:
            raise InputError(f"{arm.file}: unknown joint {name!r}; there are: {', '.join(known)}")
    return np.array([known[name] for name in arm.joints or known], dtype=np.intp)


def home_qpos(model: Any) -> NDArray[np.float64]:
    """Return the positions (nq,) of the keyframe `home`, else the middles of the joint ranges."""
    for key in range(model.nkey):
        if model.key(key).name == HOME_KEY:
            return model.key_qpos[key].copy()
    posture = model.qpos0.copy()
    for joint in np.flatnonzero(model.jnt_limited):
        posture[model.jnt_qposadr[joint]] = model.jnt_range[joint].mean()
    return posture


def frame_views(
    model: Any, data: Any, name: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return views of origin (3,) and axes (9,) of a site or body."""
    sites = [model.site(site).name for site in range(model.nsite)]
    bodies = [model.body(body).name for body in range(model.nbody)]
    if name in sites:
        return data.site_xpos[sites.index(name)], data.site_xmat[sites.index(name)]
    if name in bodies:
        return data.xpos[bodies.index(name)], data.xmat[bodies.index(name)]
    raise InputError(f"unknown frame {name!r}; sites: {sites}; bodies: {bodies}")


def clearance_pairs(model: Any) -> NDArray[np.intp]:
    """List the pairs of geoms of a model that may touch: (P, 2) numbers, the lower one first.

    The list leaves out geoms without collision, pairs without relative motion, neighbours that
    share a joint, pairs that the model excludes, and links nearer than SELF_MARGIN_M at home.
    """
    mujoco = import_mujoco()
    data = mujoco.MjData(model)
    data.qpos[:] = home_qpos(model)
    mujoco.mj_kinematics(model, data)
    solid = np.flatnonzero(model.geom_contype | model.geom_conaffinity).tolist()
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
            if welds[0] == welds[1] or neighbours or tuple(bodies) in excluded:
                continue
            added = OBSTACLE_GROUP in (model.geom_group[one], model.geom_group[other])
            apart = mujoco.mj_geomDistance(model, data, one, other, SELF_MARGIN_M, None)
            if added or apart >= SELF_MARGIN_M:
                pairs.append((one, other))
    return np.array(pairs, dtype=np.intp).reshape(-1, 2)

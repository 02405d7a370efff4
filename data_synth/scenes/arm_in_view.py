"""A robot arm with a hand that reaches into a scene, as fixtures that do not move."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from ..arms import HAND, LBR_ARM, PALM_BEFORE_FLANGE_M, TOOL_SITE
from ..mujoco_import import import_mujoco
from .fixture import Fixture, Outline
from .furnished_settings import Setting
from .tabletop_spec import VISIBLE_GROUPS

PEDESTAL_RADIUS_M = 0.1
"""Radius of the column under the arm's base."""
BASE_DISTANCE_M = (0.42, 0.62)
"""Horizontal distance of the arm's base from the point it reaches for: its middle range."""
MIN_SIDE = np.radians(50)
"""Minimum angle between arm and camera, seen from above, rad: the arm does not hide everything."""
MAX_TILT = np.radians(25)
"""Maximum angle between the hand and the setting's direction of approach, rad."""

FOOT_PARTS = 5
"""The first parts of an arm: pedestal, base and first link. They may stand in a table."""

_PEDESTAL_GAP_M = 0.002
_FINGERTIP_M = 0.17
"""Distance from the flange to the fingertips."""
_TRIES = 20
_STEPS = 80
"""Newton steps of the inverse kinematics."""
_DAMPING = 0.05
_REACHED_M, _ALIGNED = 0.01, 0.1
_JOINT_SHARE = 0.95
"""Share of each joint's range that postures use."""


def draw_arm(
    setting: Setting, camera_azimuth: float, rng: np.random.Generator
) -> tuple[Fixture, ...] | None:
    """Draw an arm in a random posture whose fingertips are near the setting's point of reach.

    The included arm and hand are used. It may touch parts of the scene.

    Parameters
    ----------
    setting
        The furniture; its first plane is the floor on which the arm's pedestal stands.
    camera_azimuth
        Direction from the scene to the camera about z, rad.
    rng
        Source of randomness.

    Returns
    -------
    tuple of Fixture, or None
        Parts of kind ``robot``; None if no posture was found.
    """
    floor = min(item.pose.translation[2] for item in setting.fixtures if item.outline == "plane")
    for _ in range(_TRIES):
        goal = np.array(setting.reach) + rng.uniform(-1, 1, 3) * setting.reach_spread
        tilt = rng.uniform(0, MAX_TILT) * _unit(rng.standard_normal(3))
        approach = Rotation.from_rotvec(tilt).apply(_unit(np.array(setting.approach)))
        side = camera_azimuth + rng.uniform(MIN_SIDE, 2 * np.pi - MIN_SIDE)
        away = rng.uniform(*BASE_DISTANCE_M)
        base = [*(goal[:2] + away * np.array([np.cos(side), np.sin(side)])), setting.base_height]
        T_world_base = RigidTransform.from_components(base, Rotation.from_euler("Z", side + np.pi))
        flange = goal - _FINGERTIP_M * approach
        into = T_world_base.inv()
        parts = _posed(into.apply(flange), into.rotation.apply(approach), rng)
        if parts is not None:
            # Slightly below the base, so that it does not share a plane with a table's top.
            high = setting.base_height - _PEDESTAL_GAP_M
            half = (PEDESTAL_RADIUS_M, PEDESTAL_RADIUS_M, max((high - floor) / 2, _PEDESTAL_GAP_M))
            middle = RigidTransform.from_translation([*base[:2], high - half[2]])
            column = Fixture("robot", "cylinder", half, pose=middle, colour=(0.3, 0.32, 0.35))
            return (column, *(part.moved(T_world_base) for part in parts))
    return None


def _posed(
    flange: NDArray[np.float64], approach: NDArray[np.float64], rng: np.random.Generator
) -> list[Fixture] | None:
    """Return arm and hand with the flange at a place and direction in the base's frame, or None.

    Damped least squares from a random posture (Wampler 1986).
    """
    mujoco, model = import_mujoco(), _model(str(LBR_ARM))
    data = mujoco.MjData(model)
    low, high = _JOINT_SHARE * model.jnt_range.T
    data.qpos[:] = rng.uniform(0.6 * low, 0.6 * high)
    site = model.site(TOOL_SITE).id
    jacobian = np.zeros((6, model.nv))
    for _ in range(_STEPS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        axis = data.site_xmat[site].reshape(3, 3)[:, 2]
        error = np.concatenate([flange - data.site_xpos[site], np.cross(axis, approach)])
        aligned = axis @ approach > 1 - _ALIGNED
        if np.linalg.norm(error[:3]) < _REACHED_M and aligned:
            return [*_parts(model, data), *_hand(data, site)]
        mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], site)
        square = jacobian @ jacobian.T + _DAMPING**2 * np.eye(6)
        step = jacobian.T @ np.linalg.solve(square, error)
        data.qpos[:] = np.clip(data.qpos + np.clip(step, -0.3, 0.3), low, high)
    return None


def _hand(arm_data: Any, site: int) -> list[Fixture]:
    mujoco, model = import_mujoco(), _model(str(HAND))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    turn = Rotation.from_matrix(arm_data.site_xmat[site].reshape(3, 3))
    flange = RigidTransform.from_components(arm_data.site_xpos[site], turn)
    palm = flange * RigidTransform.from_translation([0, 0, PALM_BEFORE_FLANGE_M])
    return [part.moved(palm) for part in _parts(model, data)]


def _parts(model: Any, data: Any) -> list[Fixture]:
    """Return the visible geoms of a model in its present posture."""
    types = import_mujoco().mjtGeom
    outlines: dict[int, Outline] = {
        int(types.mjGEOM_BOX): "box",
        int(types.mjGEOM_SPHERE): "sphere",
        int(types.mjGEOM_ELLIPSOID): "ellipsoid",
        int(types.mjGEOM_CYLINDER): "cylinder",
        int(types.mjGEOM_CAPSULE): "capsule",
    }
    parts = []
    for geom in range(model.ngeom):
        if not VISIBLE_GROUPS[model.geom_group[geom]]:
            continue
        outline = outlines[int(model.geom_type[geom])]
        x, y, z = (float(length) for length in model.geom_size[geom])
        half = (x, x, y) if outline in ("cylinder", "capsule") else (x, y, z)
        turn = Rotation.from_matrix(data.geom_xmat[geom].reshape(3, 3))
        pose = RigidTransform.from_components(data.geom_xpos[geom], turn)
        material = model.geom_matid[geom]
        rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        red, green, blue = (float(share) for share in rgba[:3])
        parts.append(Fixture("robot", outline, half, pose=pose, colour=(red, green, blue)))
    return parts


@functools.cache
def _model(path: str) -> Any:
    return import_mujoco().MjModel.from_xml_path(path)


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)

"""Visual parts of a grasping cell: light, background, table legs, the camera's mast."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..mujoco_import import import_mujoco
from .grasp_cell import STEEL, GraspCell

SLICES = 56
"""Facets of round geoms. A 120 mm ball is exact to 0.1 mm, a twentieth of the camera's noise. The
rendering time grows with their square."""
SHADOW_PX = 3072
"""Size of the shadow map: shadows on the table are sharp to a few mm."""

DISPLAY_EYE = (1.35, 1.5, 1.0)
DISPLAY_TARGET = (0.02, -0.22, 0.36)
"""Camera position and target for pictures, world, m: in front of the table, facing the robot."""
DISPLAY_FOCAL_SHARE = 0.98
"""Focal length of that camera over the image width."""

_LAMP = (0.55, 1.25, 2.9)
_LAMP_AT = (0.0, -0.15, 0.1)
_LAMP_CUTOFF_DEG = 52.0
_LAMP_SHADOWED = 0.5
"""Share of the lamp's cone that has shadows: all of the cell, and the table's own on the floor."""
_LAMP_COLOUR = (0.70, 0.67, 0.62)
_FILL = (-1.6, 0.6, 1.8)
_FILL_COLOUR = (0.14, 0.17, 0.22)
_AMBIENT = (0.40, 0.40, 0.41)
_SKY = (0.50, 0.53, 0.58)
_HORIZON = (0.36, 0.37, 0.38)
_HORIZON_SEEN = (0.43, 0.45, 0.48)
_SKY_PX = 256
_FLOOR = (0.66, 0.66, 0.67, 1.0)
_FLOOR_FACET_M = 0.4

_LEG_M = 0.022
_LEG_INSET_M = 0.06
_TABLE_THICKNESS_M = 0.03
_MAST_M = 0.012
_MAST_BEHIND_M = 0.12
"""Distance of the mast behind the camera, so that the camera does not see it."""
_CAMERA_HALF_M = (0.045, 0.0125, 0.0125)
_NO_CONTACT = {"contype": 0, "conaffinity": 0}


def add_cell_visuals(spec: Any, cell: GraspCell) -> None:
    """Add visual parts to a cell's `MjSpec`, which already has a lamp and a floor."""
    mujoco = import_mujoco()
    _add_light(mujoco, spec)
    _add_legs(mujoco, spec, cell)
    _add_mast(mujoco, spec, cell)


def _add_light(mujoco: Any, spec: Any) -> None:
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2, sky.width, sky.height = _SKY, _HORIZON, _SKY_PX, 6 * _SKY_PX
    lamp = spec.light("lamp")
    lamp.pos, lamp.dir = _LAMP, np.subtract(_LAMP_AT, _LAMP)
    lamp.cutoff, lamp.diffuse = _LAMP_CUTOFF_DEG, _LAMP_COLOUR
    fill = spec.worldbody.add_light(name="fill", castshadow=False, cutoff=80.0)
    fill.pos, fill.dir = _FILL, np.negative(_FILL)
    fill.diffuse, fill.specular = _FILL_COLOUR, [0.0] * 3
    floor = spec.geom("floor")
    floor.rgba, floor.size = _FLOOR, [0, 0, _FLOOR_FACET_M]
    spec.visual.rgba.haze = [*_HORIZON_SEEN, 1.0]
    visual = spec.visual
    visual.headlight.ambient = _AMBIENT
    visual.map.shadowscale = _LAMP_SHADOWED
    visual.quality.shadowsize = SHADOW_PX
    visual.quality.numslices, visual.quality.numstacks = SLICES, SLICES // 2


def _add_legs(mujoco: Any, spec: Any, cell: GraspCell) -> None:
    table = cell.table
    x, y = 0.5 * np.array(table.size) - _LEG_INSET_M
    high, low = table.height - _TABLE_THICKNESS_M, table.height - table.floor_drop
    for sx, sy in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        leg = spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, material=STEEL, **_NO_CONTACT)
        leg.pos = [sx * x, sy * y, 0.5 * (high + low)]
        leg.size = [_LEG_M, _LEG_M, 0.5 * (high - low)]


def _add_mast(mujoco: Any, spec: Any, cell: GraspCell) -> None:
    table, eye = cell.table, np.array(cell.T_world_camera.translation)
    turn = cell.T_world_camera.rotation
    forward = turn.as_matrix()[:, 2]
    level = forward * [1, 1, 0]
    foot = eye - _MAST_BEHIND_M * level / max(float(np.linalg.norm(level)), 1e-9)
    # Beside the table, not through it.
    foot[0] = min(foot[0], -0.5 * table.size[0] - 3 * _MAST_M)
    top, floor = [*foot[:2], eye[2] + 0.02], table.height - table.floor_drop
    poles = (
        ([*foot[:2], floor], top, _MAST_M),
        (top, eye - 2 * _CAMERA_HALF_M[2] * forward, 0.6 * _MAST_M),
    )
    for start, end, radius in poles:
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[*start, *end],
            size=[radius, 0, 0],
            material=STEEL,
            **_NO_CONTACT,
        )
    # Behind the optical centre: the camera must not see itself.
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=_CAMERA_HALF_M,
        pos=eye - 2 * _CAMERA_HALF_M[2] * forward,
        quat=turn.as_quat(scalar_first=True),
        material=STEEL,
        **_NO_CONTACT,
    )

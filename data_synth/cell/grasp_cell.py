"""Layout of a grasping cell: robot base, work area, tray and camera, and the furniture."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.errors import InputError
from eyehand.perception import CameraIntrinsics

from ..mujoco_import import import_mujoco
from ..scenes.tabletop_options import TabletopOptions
from ..scenes.tabletop_scene import Family, Table
from ..scenes.tabletop_spec import SLIDING_FRICTION
from ..scenes.viewpoint import look_at

WORK_AREA_M = (0.42, 0.37)
"""Objects lie inside this rectangle in the middle of the table. Everywhere in it the hand can point
straight down, and horizontally in at least one direction."""
PILE_SPREAD = 0.5
"""See `TabletopOptions.pile_spread`."""
_LANDING_AREA_M = (0.50, 0.46)
"""Extent of the area in which falling objects may come to rest. The arm reaches all of it."""

_FOCAL_PX = 525.0
_IMAGE_PX = (640, 480)
_CAMERA_VIEW = (0.85, np.radians(45.0), np.radians(190.0))
"""Distance to the target, m; elevation and azimuth, rad. The camera is opposite the tray, to the
left of the robot. Its image shows the whole work area up to a height of 0.25 m."""
_CAMERA_TARGET = (0.0, 0.0, 0.07)

STEEL = "steel"
"""Material of pedestal, mast and legs."""
_STEEL_COLOUR = (0.30, 0.32, 0.35, 1.0)
_TRAY_COLOUR = (0.26, 0.36, 0.44, 1.0)
_PEDESTAL_RADIUS_M = 0.105
_PLATE_M = (0.17, 0.012)
"""Radius and thickness of the foot of the pedestal. The plate on top is narrower."""


def _camera_pose() -> RigidTransform:
    distance, elevation, azimuth = _CAMERA_VIEW
    level = np.cos(elevation)
    away = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    return look_at(np.add(_CAMERA_TARGET, distance * np.array(away)), _CAMERA_TARGET)


def _base_pose() -> RigidTransform:
    return RigidTransform.from_components(
        [0.0, -0.58, 0.09], Rotation.from_rotvec([0, 0, np.pi / 2])
    )


def _intrinsics() -> CameraIntrinsics:
    wide, high = _IMAGE_PX
    return CameraIntrinsics(_FOCAL_PX, _FOCAL_PX, (wide - 1) / 2, (high - 1) / 2, wide, high)


@dataclass(frozen=True)
class GraspCell:
    """Poses in the cell; world z up, the table's top at z = 0, its middle at the origin."""

    T_world_base: RigidTransform = field(default_factory=_base_pose)
    """Robot base, on a pedestal beside the table; its x-axis points over the table."""
    table: Table = field(default_factory=Table)
    """The table; its top is at z = 0."""
    tray_centre: tuple[float, float, float] = (0.43, -0.19, 0.006)
    """Middle of the upper face of the tray's floor, world, m."""
    tray_size: tuple[float, float] = (0.25, 0.36)
    """Inner extent along x and y, m."""
    tray_height: float = 0.07
    """Height of the walls over the tray's floor, m."""
    tray_wall: float = 0.006
    """Thickness of its walls and floor, m."""
    T_world_camera: RigidTransform = field(default_factory=_camera_pose)
    """The depth camera (x right, y down, z forward)."""
    intrinsics: CameraIntrinsics = field(default_factory=_intrinsics)
    """Intrinsics of the depth camera."""

    def is_over_tray(self, points: NDArray[np.float64]) -> Any:
        """Return a mask (…,) of the points (…, 3), world, m, over the tray or its walls."""
        half = 0.5 * np.asarray(self.tray_size) + self.tray_wall
        return np.all(np.abs(points[..., :2] - self.tray_centre[:2]) <= half, axis=-1)

    def check_clear(self, name: str, centre: NDArray[np.float64], radius: float) -> None:
        """Raise an `InputError` if a ball around an object overlaps the tray's area."""
        half = 0.5 * np.asarray(self.tray_size) + self.tray_wall
        if np.all(np.abs(centre[:2] - self.tray_centre[:2]) - half < radius):
            raise InputError(
                f"object {name} at {np.round(centre, 3).tolist()} m overlaps the tray at "
                f"{self.tray_centre} m; keep objects in the work area"
            )

    def add_furniture(self, spec: Any) -> None:
        """Add the pedestal and the tray to a scene's `MjSpec`. Both take part in collisions."""
        mujoco = import_mujoco()
        spec.add_material(name=STEEL, rgba=_STEEL_COLOUR, specular=0.5, shininess=0.6)
        spec.add_material(name="tray", rgba=_TRAY_COLOUR, specular=0.2, shininess=0.4)
        add_pedestal(spec, self, material=STEEL)
        self._add_tray(mujoco, spec)

    def _add_tray(self, mujoco: Any, spec: Any) -> None:
        (x, y), t, h = 0.5 * np.asarray(self.tray_size), self.tray_wall, self.tray_height
        body = spec.worldbody.add_body(name="tray", pos=self.tray_centre)
        parts = (
            ("tray_floor", (0, 0, -t / 2), (x + t, y + t, t / 2)),
            ("tray_left", (-x - t / 2, 0, h / 2), (t / 2, y + t, h / 2)),
            ("tray_right", (x + t / 2, 0, h / 2), (t / 2, y + t, h / 2)),
            ("tray_front", (0, -y - t / 2, h / 2), (x, t / 2, h / 2)),
            ("tray_back", (0, y + t / 2, h / 2), (x, t / 2, h / 2)),
        )
        for name, place, half in parts:
            geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_BOX, pos=place, size=half)
            geom.material, geom.condim = "tray", 4
            geom.friction = [SLIDING_FRICTION, 0.005, 0.002]


def add_pedestal(spec: Any, cell: GraspCell, material: str = "") -> None:
    """Add the column under the robot's base to a spec."""
    mujoco = import_mujoco()
    place = cell.T_world_base.translation
    floor = cell.table.height - cell.table.floor_drop
    radius, thick = _PLATE_M
    parts = (
        ("pedestal", _PEDESTAL_RADIUS_M, floor, place[2] - thick),
        ("pedestal_top", radius - 0.05, place[2] - thick, place[2]),
        ("pedestal_foot", radius, floor, floor + thick),
    )
    for name, size, low, high in parts:
        geom = spec.worldbody.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_CYLINDER)
        geom.size = [size, 0.5 * (high - low), 0]
        geom.pos = [place[0], place[1], 0.5 * (low + high)]
        if material:
            geom.material = material


def scene_options(
    family: Family = "separate", count_range: tuple[int, int] = (5, 5), **changes: Any
) -> TabletopOptions:
    """Return options of scenes for the cell: `make_scene(seed, scene_options(...))`.

    Parameters
    ----------
    family, count_range
        As in `TabletopOptions`.
    **changes
        Any other field of `TabletopOptions`.
    """
    fields: dict[str, Any] = {
        "work_area": WORK_AREA_M,
        # No object comes to rest out of reach or in the tray's area.
        "table_size": _LANDING_AREA_M,
        "pile_spread": PILE_SPREAD,
    }
    return TabletopOptions(family=family, count_range=count_range, **(fields | changes))

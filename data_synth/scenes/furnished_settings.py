"""Random furniture of each furnished family: fixtures, places for objects, and camera ranges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from . import furniture
from .fixture import Colour, Fixture
from .furnished_scene import FurnishedFamily

MEAN_FOOTPRINT_M2 = 0.0045
"""Area that a lying object covers on average, with the sizes in `Setting`."""
HALF_VIEW = 0.45
"""Tangent of half the camera's vertical angle of view, rounded."""

_SCATTERED, _HEAPED, _FULL = (0.25, 0.7), (0.8, 1.4), (2.6, 3.6)
"""Ranges of the objects' footprint over a container's floor. The last hides the floor entirely."""
MAX_IMAGINED = 24
"""Maximum number of objects for which empty furniture is sized."""
FULL_COUNT = 36
"""Number of objects of a container whose floor is hidden."""
_FILL_CHANCES = (0.45, 0.35, 0.20)


@dataclass(frozen=True)
class DropZone:
    """A horizontal rectangle onto which objects fall."""

    T_world_zone: RigidTransform
    """Pose of the rectangle; its z-axis points up."""
    half: tuple[float, float]
    """Half extents along the zone's x and y, m."""
    headroom: float = np.inf
    """Free height over the rectangle, m."""
    start: float = 0.0
    """Height over the rectangle from which objects are lowered, at least, m."""
    share: float = 1.0
    """Weight with which objects are assigned to this zone."""
    upright: float = 0.3
    """Probability that an object starts upright rather than in any orientation."""

    def holds(self, points: NDArray[np.float64], margin: float) -> NDArray[np.bool_]:
        """Return a mask (N,) of points (N, 3), world, m, over the rectangle grown by `margin`."""
        local = self.T_world_zone.inv().apply(points)
        inside = np.all(np.abs(local[:, :2]) <= np.array(self.half) + margin, axis=1)
        return inside & (local[:, 2] > 0) & (local[:, 2] < self.headroom)


@dataclass(frozen=True)
class Setting:
    """Furniture with places for objects, and where the camera may be."""

    fixtures: tuple[Fixture, ...]
    """The furniture."""
    zones: tuple[DropZone, ...]
    """Places for objects."""
    radius: float
    """Radius of the part that the camera shows, m."""
    elevation: tuple[float, float]
    """Range of the angle of the optical axis below the horizon, rad."""
    target: tuple[float, float, float] = (0.0, 0.0, 0.03)
    """Middle of the part that the camera shows, world, m."""
    azimuth: tuple[float, float] = (-np.pi, np.pi)
    """Range of the direction from the target to the camera about z, rad; -π/2 is on -y."""
    width_range: tuple[float, float] = (0.03, 0.10)
    """Horizontal extent of an upright solid, m."""
    height_range: tuple[float, float] = (0.03, 0.16)
    """Extent of a solid along its third axis, m."""
    distances: tuple[float, float] = field(default=(0.5, 1.8))
    """Limits of the distance from the target to the camera, m."""
    reach: tuple[float, float, float] = (0.0, 0.0, 0.18)
    """Point near which the fingertips of a robot arm are, world, m."""
    reach_spread: tuple[float, float, float] = (0.1, 0.1, 0.05)
    """Maximum distance of the fingertips from that point along each axis, m."""
    approach: tuple[float, float, float] = (0.0, 0.0, -1.0)
    """Direction in which the hand points."""
    base_height: float = 0.0
    """World z of the arm's base, m."""
    full: bool = False
    """Whether to use `FULL_COUNT` objects, or as many as the options allow, to hide the floor."""


def draw_setting(family: FurnishedFamily, count: int, rng: np.random.Generator) -> Setting:
    """Draw the furniture of a family for a number of objects; for 0, as if for any number."""
    return _DRAWS[family](count or int(rng.integers(1, MAX_IMAGINED + 1)), rng)


def _bin(count: int, rng: np.random.Generator) -> Setting:
    style = rng.choice(3, p=_FILL_CHANCES)
    full = bool(style == 2)
    fill = rng.uniform(*(_SCATTERED, _HEAPED, _FULL)[style])
    least = (0.26, 0.18) if full else (0.2, 0.14)
    size = _floor_size(FULL_COUNT if full else count, fill, least, (0.56, 0.38), rng)
    height = float(rng.uniform(0.12 if full else 0.07, min(0.2, 0.8 * size[1])))
    lip = rng.uniform(0.008, 0.02) if rng.random() < 0.5 else 0.0
    thickness = rng.uniform(0.003, 0.008)
    parts = furniture.container(size, height, _paint(rng), thickness=thickness, lip=lip)
    zone = _inside(size, height, thickness)
    return Setting(
        (*parts, *_underneath(rng)),
        (zone,),
        radius=0.5 * float(np.hypot(*size)) + 0.06,
        elevation=(np.radians(55), np.radians(88)),
        target=(0.0, 0.0, height / 2),
        height_range=(0.03, 0.12),
        reach=(0.0, 0.0, height + 0.08),
        full=full,
    )


def _tote(count: int, rng: np.random.Generator) -> Setting:
    fill = rng.uniform(*(_SCATTERED, _HEAPED)[rng.choice(2)])
    size = _floor_size(count, fill, (0.34, 0.26), (0.6, 0.42), rng)
    height = rng.uniform(0.2, 0.34)
    taper = np.radians(rng.uniform(3, 9))
    lip = rng.uniform(0.015, 0.03)
    parts = furniture.container(size, height, _paint(rng), taper=taper, thickness=0.004, lip=lip)
    zone = _inside(size, height, 0.004)
    opening = np.array(size) + 2 * height * np.tan(taper)
    return Setting(
        (*parts, *_underneath(rng)),
        (zone,),
        radius=0.5 * float(np.hypot(*opening)) + 0.05,
        elevation=(np.radians(55), np.radians(86)),
        target=(0.0, 0.0, 0.4 * height),
        reach=(0.0, 0.0, height + 0.05),
        width_range=(0.04, 0.13),
        height_range=(0.04, 0.22),
    )


def _tray(count: int, rng: np.random.Generator) -> Setting:
    del count
    size = (float(rng.uniform(0.26, 0.45)), float(rng.uniform(0.2, 0.34)))
    rim = rng.uniform(0.010, 0.030)
    thickness = rng.uniform(0.002, 0.006)
    taper = np.radians(rng.uniform(0, 35))
    parts = furniture.container(size, rim, _paint(rng), taper=taper, thickness=thickness)
    inside = DropZone(
        RigidTransform.from_translation([0, 0, thickness]),
        (size[0] / 2 - 0.02, size[1] / 2 - 0.02),
        share=2.0,
        upright=0.6,
    )
    beside = [
        DropZone(
            RigidTransform.from_translation([side * (size[0] / 2 + 0.13), 0, 0]),
            (0.06, size[1] / 2),
            share=0.5,
            upright=0.6,
        )
        for side in (-1, 1)
    ]
    return Setting(
        (*parts, *furniture.table((1.2, 0.8), 0.72, _wood(rng)), _floor(-0.72, rng)),
        (inside, *beside),
        radius=0.36,
        elevation=(np.radians(32), np.radians(75)),
    )


def _shelf(count: int, rng: np.random.Generator) -> Setting:
    size = (float(rng.uniform(0.55, 0.9)), float(rng.uniform(0.24, 0.36)))
    gap = rng.uniform(0.22, 0.34)
    boards = int(rng.integers(1, 4)) if count < 8 else int(rng.integers(2, 4))
    levels = tuple(float(k * gap) for k in range(boards))
    # Half of the shelves have a board over the topmost compartment.
    covered = (*levels, levels[-1] + gap) if rng.random() < 0.5 else levels
    height = levels[-1] + gap
    parts = furniture.shelf(size, covered, height, _wood(rng))
    # The lamp stands on the side of +y, where the shelf opens.
    turn = _placed(0.0, 0.0, np.pi)
    zones = tuple(
        DropZone(
            turn * RigidTransform.from_translation([0, -0.01, z]),
            (size[0] / 2 - 0.03, size[1] / 2 - 0.03),
            headroom=gap - furniture.BOARD_M,
            upright=0.8,
        )
        for z in levels
    )
    below = float(rng.uniform(0.1, 0.8))
    parts.append(furniture.room_wall(0.3 + size[1] / 2, -below, _pale(rng)))
    return Setting(
        (*(part.moved(turn) for part in parts), _floor(-below, rng)),
        zones,
        radius=0.5 * max(size[0], 1.2 * height),
        elevation=(np.radians(3), np.radians(32)),
        target=(0.0, 0.0, float(height / 2)),
        azimuth=(np.pi / 2 - np.radians(40), np.pi / 2 + np.radians(40)),
        width_range=(0.035, 0.10),
        height_range=(0.05, 0.18),
        reach=(0.0, size[1] / 2 + 0.06, float(rng.choice(levels)) + 0.14),
        reach_spread=(0.3 * size[0], 0.04, 0.03),
        approach=(0.0, -1.0, 0.0),
        base_height=-below + 0.01,
    )


def _clutter(count: int, rng: np.random.Generator) -> Setting:
    size = (float(rng.uniform(0.9, 1.5)), float(rng.uniform(0.6, 0.9)))
    spread = np.sqrt(count * MEAN_FOOTPRINT_M2 / rng.uniform(0.45, 1.0))
    half = (
        min(float(0.5 * spread * 1.25), size[0] / 2 - 0.08),
        min(float(0.5 * spread / 1.25), size[1] / 2 - 0.08),
    )
    # The objects lie on the side of the table that is nearer to the camera.
    front = -(size[1] / 2 - 0.05 - half[1]) * rng.uniform(0.0, 0.7)
    zone = DropZone(RigidTransform.from_translation([0, front, 0]), half, upright=0.5)
    return Setting(
        (*furniture.table(size, 0.72, _wood(rng)), *_room(size, front + half[1], rng)),
        (zone,),
        radius=1.15 * max(half) + 0.05,
        elevation=(np.radians(25), np.radians(60)),
        target=(0.0, float(front), 0.05),
        reach=(0.0, float(front), 0.26),
        azimuth=(-np.pi / 2 - 0.7, -np.pi / 2 + 0.7),
        width_range=(0.03, 0.12),
        height_range=(0.03, 0.22),
    )


def _small_table(count: int, rng: np.random.Generator) -> Setting:
    least = max(0.15, float(np.sqrt(2.5 * count * MEAN_FOOTPRINT_M2)))
    wide = float(rng.uniform(least, max(least, 0.5)))
    size = (wide, float(wide * rng.uniform(0.67, 1.0)))
    drop = float(rng.uniform(0.25, 0.75))
    turned = wide > 0.25 and rng.random() < 0.35
    parts = furniture.pedestal(size, drop, _wood(rng), turned=turned)
    zone = DropZone(
        RigidTransform.identity(),
        (max(0.35 * size[0], size[0] / 2 - 0.06), max(0.35 * size[1], size[1] / 2 - 0.06)),
        upright=0.8,
    )
    surroundings = []
    if rng.random() < 0.5:
        surroundings.append(furniture.room_wall(rng.uniform(0.5, 1.5), -drop, _pale(rng)))
    return Setting(
        (*parts, _floor(-drop, rng), *surroundings),
        (zone,),
        radius=0.55 * wide + 0.08,
        elevation=(np.radians(25), np.radians(65)),
        azimuth=(-np.pi / 2 - 1.0, -np.pi / 2 + 1.0),
        width_range=(0.03, 0.09),
        height_range=(0.03, 0.15),
    )


_DRAWS: dict[FurnishedFamily, Callable[[int, np.random.Generator], Setting]] = {
    "bin": _bin,
    "tote": _tote,
    "shelf": _shelf,
    "tray": _tray,
    "clutter": _clutter,
    "small-table": _small_table,
}


def _floor_size(
    count: int,
    fill: float,
    least: tuple[float, float],
    most: tuple[float, float],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the extent of a floor that `count` objects cover `fill` times, within limits, m."""
    ratio = rng.uniform(1.2, 1.7)
    wide = np.sqrt(count * MEAN_FOOTPRINT_M2 / fill * ratio)
    size = np.clip([wide, wide / ratio], least, most)
    return float(size[0]), float(size[1])


def _inside(size: tuple[float, float], height: float, thickness: float) -> DropZone:
    # Objects start with their middle off the walls by about half of their width.
    half = tuple(max(0.2 * extent, extent / 2 - 0.05) for extent in size)
    base = RigidTransform.from_translation([0, 0, thickness])
    return DropZone(base, (half[0], half[1]), start=height, upright=0.15)


def _underneath(rng: np.random.Generator) -> list[Fixture]:
    """Return a table with a floor, or only a floor, below a container."""
    if rng.random() < 0.6:
        size = (float(rng.uniform(0.8, 1.4)), float(rng.uniform(0.6, 0.9)))
        return [*furniture.table(size, 0.72, _wood(rng)), _floor(-0.72, rng)]
    return [_floor(0.0, rng)]


def _room(size: tuple[float, float], occupied: float, rng: np.random.Generator) -> list[Fixture]:
    """Draw what stands on and around a table, behind what lies in front of y = `occupied`."""
    z = -0.72
    parts = [_floor(z, rng)]
    behind = size[1] / 2
    if rng.random() < 0.6:
        parts.append(furniture.room_wall(behind + rng.uniform(0.02, 1.2), z, _pale(rng)))
    width = float(rng.uniform(0.4, 0.6))
    if rng.random() < 0.4 and occupied + 0.2 < behind:
        place = _placed(rng.uniform(-0.4, 0.4) * size[0], behind - 0.14, rng.uniform(-0.4, 0.4))
        parts += [part.moved(place) for part in furniture.screen(width, (0.08, 0.08, 0.09))]
    for _ in range(int(rng.integers(0, 3))):
        side = rng.choice([-1, 1])
        turn = rng.uniform(-np.pi, np.pi)
        at = _placed(side * (size[0] / 2 + rng.uniform(0.05, 0.35)), rng.uniform(-0.2, 0.6), turn)
        parts += [part.moved(at) for part in furniture.chair(z, _paint(rng))]
    if rng.random() < 0.4:
        extent = (float(rng.uniform(0.4, 0.8)), 0.4, float(rng.uniform(0.5, 1.6)))
        at = _placed(rng.uniform(-1.0, 1.0), behind + rng.uniform(0.25, 0.8), 0.0)
        parts += [part.moved(at) for part in furniture.cabinet(extent, z, _pale(rng))]
    return parts


def _placed(x: float, y: float, yaw: float) -> RigidTransform:
    return RigidTransform.from_components([x, y, 0.0], Rotation.from_euler("Z", yaw))


def _floor(z: float, rng: np.random.Generator) -> Fixture:
    return furniture.ground(z, _pale(rng))


def _paint(rng: np.random.Generator) -> Colour:
    red, green, blue = rng.uniform(0.15, 0.75, size=3)
    return float(red), float(green), float(blue)


def _pale(rng: np.random.Generator) -> Colour:
    grey = rng.uniform(0.5, 0.8)
    red, green, blue = np.clip(grey + rng.uniform(-0.06, 0.06, size=3), 0, 1)
    return float(red), float(green), float(blue)


def _wood(rng: np.random.Generator) -> Colour:
    shade = rng.uniform(0.6, 1.1)
    red, green, blue = np.clip(shade * np.array([0.76, 0.62, 0.46]), 0, 1)
    return float(red), float(green), float(blue)

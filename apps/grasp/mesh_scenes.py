"""Random scenes of objects from a folder of meshes or URDFs."""

from __future__ import annotations

import colorsys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.scenes import FolderObject, MeshObject, Split, read_objects, select_half
from eyehand.errors import InputError

from .scenes import PACKED_AREA, PACKED_GAP, WORK_AREA, GraspFamily

MAX_PLACEMENTS = 300
"""Number of random positions tried for one object before the layout counts as full."""
MAX_LAYOUTS = 8
"""Number of layouts tried. One large object in the middle can fill a layout alone."""
CELL = GraspCell()
"""The default cell. No object may overlap its tray."""
PILE_GAP = 0.03
"""Vertical gap between the objects of a pile before they fall, m."""
TABLE_GAP = 0.001
"""Initial height of the objects above the table, m."""
HUE_STEP = 0.618
"""Hue step between successive objects, the golden ratio. It keeps successive hues apart."""


@dataclass(frozen=True)
class ObjectSource:
    """The objects that scenes are drawn from."""

    folder: str
    """Folder of meshes or URDFs."""
    split: Split = "all"
    """All of them, or one half by their names."""
    density: float | None = None
    """Density of all objects, kg/m³; None for the masses of the files."""

    def read(self) -> tuple[FolderObject, ...]:
        """Read the objects.

        Raises
        ------
        InputError
            As :func:`eyehand.data_synth.scenes.read_objects`, and if the half is empty.
        """
        found = read_objects(self.folder, self.density)
        return select_half(found, [item.file.stem for item in found], self.split)


def mesh_scene(
    source: ObjectSource, family: GraspFamily, seed: int, objects: int
) -> tuple[MeshObject, ...]:
    """Draw objects and place them at random.

    Each object stands as in its file, rotated about the vertical. The objects of a pile have random
    orientations and start above each other; they fall in the simulation.

    Raises
    ------
    InputError
        If the folder holds no objects, or if they do not fit on the table.
    """
    return _draw_scene(source.read(), family, seed, objects)


def check_mesh_scenes(
    source: ObjectSource, scenes: Iterable[tuple[GraspFamily, int]], objects: int
) -> None:
    """Check that all scenes of a run have room for their objects, by drawing them.

    Parameters
    ----------
    source
        Where the objects come from.
    scenes
        Family and seed of each scene.
    objects
        Objects per scene. A single scene has one.

    Raises
    ------
    InputError
        As in :func:`mesh_scene`. The message names the scene.
    """
    known = source.read()
    for family, seed in scenes:
        try:
            _draw_scene(known, family, seed, objects)
        except InputError as error:
            raise InputError(f"{family} scene, seed {seed}: {error}") from error


def _draw_scene(
    known: Sequence[FolderObject], family: GraspFamily, seed: int, objects: int
) -> tuple[MeshObject, ...]:
    rng = np.random.default_rng(seed)
    count = 1 if family == "single" else objects
    max_placed = 0
    for _ in range(MAX_LAYOUTS):
        chosen = rng.choice(len(known), size=count, replace=count > len(known))
        items = _place_objects([known[index] for index in chosen], family, rng)
        if len(items) == count:
            return tuple(items)
        max_placed = max(max_placed, len(items))
    widest = max(known, key=_radius)
    raise InputError(
        f"{count} objects do not fit on the table beside the tray; the widest is {widest.file} "
        f"with {2e3 * _radius(widest):.0f} mm: request at most {max_placed} objects"
        if max_placed
        else f"{widest.file} is {2e3 * _radius(widest):.0f} mm wide, too wide for the table "
        "beside the tray"
    )


def _place_objects(
    chosen: Sequence[FolderObject], family: GraspFamily, rng: np.random.Generator
) -> list[MeshObject]:
    """Place the objects one after another, until one does not fit."""
    area = WORK_AREA if family == "single" else PACKED_AREA
    placed: list[tuple[NDArray[np.float64], float]] = []
    items: list[MeshObject] = []
    height = TABLE_GAP
    for number, item in enumerate(chosen):
        if family == "pile":
            turn = Rotation.random(rng=rng)
            low, high = _heights(item, turn)
            middle = _pile_position(item, rng)
            up = height - low
            height += high - low + PILE_GAP
        else:
            turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
            middle = _free_position(item, placed, area, rng)
            up = TABLE_GAP - _heights(item, turn)[0]
        if middle is None:
            break
        colour = colorsys.hsv_to_rgb(number * HUE_STEP % 1.0, 0.55, 0.85)
        pose = RigidTransform.from_components([*middle, up], turn)
        name = f"{item.name}_{number + 1}"
        items.append(
            MeshObject(name, item.vertices, item.faces, item.mass, colour, pose, item.pieces)
        )
    return items


def _pile_position(item: FolderObject, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Draw a position (2,) near the middle of the table, clear of the tray, m."""
    for _ in range(MAX_PLACEMENTS):
        middle = 0.25 * np.asarray(PACKED_AREA) * rng.uniform(-1.0, 1.0, 2)
        if _beside_tray(item, middle):
            return middle
    return None


def _free_position(
    item: FolderObject,
    placed: list[tuple[NDArray[np.float64], float]],
    area: tuple[float, float],
    rng: np.random.Generator,
) -> NDArray[np.float64] | None:
    """Draw a position (2,) clear of the tray and of the placed objects, m."""
    radius = _radius(item)
    for attempt in range(MAX_PLACEMENTS):
        # Enlarge the area with each attempt: an object that does not fit stands beside it.
        reach = 0.5 * np.asarray(area) * (1.0 + attempt / MAX_PLACEMENTS)
        middle = reach * rng.uniform(-1.0, 1.0, 2)
        apart = all(np.linalg.norm(middle - at) > radius + r + PACKED_GAP for at, r in placed)
        if apart and _beside_tray(item, middle):
            placed.append((middle, radius))
            return middle
    return None


def _beside_tray(item: FolderObject, middle: NDArray[np.float64]) -> bool:
    """Return whether an object in any orientation is clear of the tray."""
    try:
        CELL.check_clear(item.name, middle, float(np.linalg.norm(item.vertices, axis=1).max()))
    except InputError:
        return False
    return True


def _radius(item: FolderObject) -> float:
    """Return the radius of the object's circle on the table, m."""
    return float(np.linalg.norm(item.vertices[:, :2], axis=1).max())


def _heights(item: FolderObject, turn: Rotation) -> tuple[float, float]:
    """Return the lowest and highest z of the rotated object, m."""
    z = turn.apply(item.vertices)[:, 2]
    return float(z.min()), float(z.max())

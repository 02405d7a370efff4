"""Scenes of objects from a folder of meshes or URDFs, drawn by seed."""

from __future__ import annotations

import colorsys
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.cell import GraspCell
from eyehand.data_synth.scenes import MeshObject, read_objects
from eyehand.errors import InputError

from .scenes import PACKED_AREA, PACKED_GAP, WORK_AREA

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.data_synth.scenes import FolderObject

    from .scenes import GraspFamily

TRIES = 300
"""Draws of a place for one object before the table counts as too full ..."""
LAYOUTS = 8
"""... and tables drawn before there is no room: one large object in the middle fills it alone."""
CELL = GraspCell()
"""Where the tray stands, in whose place no object may be."""
FALL = 0.03
"""Objects of a pile begin so far above one another, m."""
LIFT = 0.001
"""Objects begin so far above the table, m."""
GOLDEN = 0.618
"""Hues turn by this share from object to object: neighbours in the list differ."""


def folder_scene(
    folder: Path | str, family: GraspFamily, seed: int, objects: int
) -> tuple[MeshObject, ...]:
    """Draw objects and their places; each stands as its file has it, turned about the vertical.

    A pile's objects are turned anyhow and begin one above the other: they fall where the scene is
    simulated.

    Raises
    ------
    InputError
        If the folder holds no objects, or they do not fit.
    """
    return _drawn(read_objects(folder), family, seed, objects)


def check_folder_scenes(
    folder: Path | str, scenes: Iterable[tuple[GraspFamily, int]], objects: int
) -> None:
    """Draw scenes without running them, to know beforehand whether there is room in all of them.

    Parameters
    ----------
    folder
        As for :func:`folder_scene`.
    scenes
        Family and seed of each.
    objects
        Of each, but for single ones.

    Raises
    ------
    InputError
        As :func:`folder_scene` does; the message names the scene.
    """
    known = read_objects(folder)
    for family, seed in scenes:
        try:
            _drawn(known, family, seed, objects)
        except InputError as error:
            raise InputError(f"{family} scene, seed {seed}: {error}") from error


def _drawn(
    known: Sequence[FolderObject], family: GraspFamily, seed: int, objects: int
) -> tuple[MeshObject, ...]:
    rng = np.random.default_rng(seed)
    count = 1 if family == "single" else objects
    most = 0
    for _ in range(LAYOUTS):
        chosen = rng.choice(len(known), size=count, replace=count > len(known))
        items = _stood([known[index] for index in chosen], family, rng)
        if len(items) == count:
            return tuple(items)
        most = max(most, len(items))
    widest = max(known, key=_radius)
    raise InputError(
        f"no room for {count} objects on the table beside the tray, the widest {widest.file} with "
        f"{2e3 * _radius(widest):.0f} mm: ask for {most} objects at most"
        if most
        else f"{widest.file}: at {2e3 * _radius(widest):.0f} mm too wide for the table beside the "
        "tray"
    )


def _stood(
    chosen: Sequence[FolderObject], family: GraspFamily, rng: np.random.Generator
) -> list[MeshObject]:
    """Give each a place, one after the other, until one finds none."""
    area = WORK_AREA if family == "single" else PACKED_AREA
    placed: list[tuple[NDArray[np.float64], float]] = []
    items: list[MeshObject] = []
    height = LIFT
    for number, item in enumerate(chosen):
        if family == "pile":
            turn = Rotation.random(rng=rng)
            low, high = _heights(item, turn)
            middle = _place_in_pile(item, rng)
            up = height - low
            height += high - low + FALL
        else:
            turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
            middle = _free_place(item, placed, area, rng)
            up = LIFT - _heights(item, turn)[0]
        if middle is None:
            break
        colour = colorsys.hsv_to_rgb(number * GOLDEN % 1.0, 0.55, 0.85)
        pose = RigidTransform.from_components([*middle, up], turn)
        name = f"{item.name}_{number + 1}"
        items.append(MeshObject(name, item.vertices, item.faces, item.mass, colour, pose))
    return items


def _place_in_pile(item: FolderObject, rng: np.random.Generator) -> NDArray[np.float64] | None:
    for _ in range(TRIES):
        middle = 0.25 * np.asarray(PACKED_AREA) * rng.uniform(-1.0, 1.0, 2)
        if _beside_tray(item, middle):
            return middle
    return None


def _free_place(
    item: FolderObject,
    placed: list[tuple[NDArray[np.float64], float]],
    area: tuple[float, float],
    rng: np.random.Generator,
) -> NDArray[np.float64] | None:
    radius = _radius(item)
    for attempt in range(TRIES):
        # A crowded table grows: what does not fit in the area stands beside it.
        reach = 0.5 * np.asarray(area) * (1.0 + attempt / TRIES)
        middle = reach * rng.uniform(-1.0, 1.0, 2)
        apart = all(np.linalg.norm(middle - at) > radius + r + PACKED_GAP for at, r in placed)
        if apart and _beside_tray(item, middle):
            placed.append((middle, radius))
            return middle
    return None


def _beside_tray(item: FolderObject, middle: NDArray[np.float64]) -> bool:
    """Whether the world would take an object there, however it is turned."""
    try:
        CELL.check_clear(item.name, middle, float(np.linalg.norm(item.vertices, axis=1).max()))
    except InputError:
        return False
    return True


def _radius(item: FolderObject) -> float:
    """Of the circle that it needs on the table, m."""
    return float(np.linalg.norm(item.vertices[:, :2], axis=1).max())


def _heights(item: FolderObject, turn: Rotation) -> tuple[float, float]:
    z = turn.apply(item.vertices)[:, 2]
    return float(z.min()), float(z.max())

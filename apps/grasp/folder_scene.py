"""Scenes of objects from a folder of meshes or URDFs, drawn by seed."""

from __future__ import annotations

import colorsys
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth.mesh_object import MeshObject
from eyehand.data_synth.object_folder import read_objects
from eyehand.errors import InputError

from .scenes import PACKED_AREA, PACKED_GAP, WORK_AREA

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from eyehand.data_synth.object_folder import FolderObject

    from .scenes import GraspFamily

TRIES = 300
"""Draws of a place for one object before the scene counts as too full."""
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
    known = read_objects(folder)
    rng = np.random.default_rng(seed)
    count = 1 if family == "single" else objects
    area = WORK_AREA if family == "single" else PACKED_AREA
    chosen = rng.choice(len(known), size=count, replace=count > len(known))
    placed: list[tuple[NDArray[np.float64], float]] = []
    items = []
    height = LIFT
    for number, index in enumerate(chosen):
        item = known[index]
        if family == "pile":
            turn = Rotation.random(rng=rng)
            low, high = _heights(item, turn)
            middle = 0.25 * np.asarray(area) * rng.uniform(-1.0, 1.0, 2)
            place = np.array([*middle, height - low])
            height += high - low + FALL
        else:
            turn = Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.0, 2.0 * np.pi)])
            place = _free_place(item, turn, placed, area, rng)
        colour = colorsys.hsv_to_rgb(number * GOLDEN % 1.0, 0.55, 0.85)
        pose = RigidTransform.from_components(place, turn)
        name = f"{item.name}_{number + 1}"
        items.append(MeshObject(name, item.vertices, item.faces, item.mass, colour, pose))
    return tuple(items)


def _free_place(
    item: FolderObject,
    turn: Rotation,
    placed: list[tuple[NDArray[np.float64], float]],
    area: tuple[float, float],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    radius = float(np.linalg.norm(item.vertices[:, :2], axis=1).max())
    low, _ = _heights(item, turn)
    for attempt in range(TRIES):
        # A crowded table grows: what does not fit in the area stands beside it.
        reach = 0.5 * np.asarray(area) * (1.0 + attempt / TRIES)
        middle = reach * rng.uniform(-1.0, 1.0, 2)
        if all(np.linalg.norm(middle - at) > radius + r + PACKED_GAP for at, r in placed):
            placed.append((middle, radius))
            return np.array([*middle, LIFT - low])
    raise InputError(
        f"{item.file}: no room for {len(placed) + 1} objects of this size on the table; ask for "
        f"{len(placed)} objects at most"
    )


def _heights(item: FolderObject, turn: Rotation) -> tuple[float, float]:
    z = turn.apply(item.vertices)[:, 2]
    return float(z.min()), float(z.max())

"""Scenes of the demo: random solids, meshes from a folder, or a scene file."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import get_args

from eyehand.data_synth import read_ground_truth
from eyehand.data_synth.scenes import MAX_OBJECTS, MeshObject, TabletopObject
from eyehand.errors import InputError

from ..console import counted
from .mesh_scenes import ObjectSource, mesh_scene
from .scenes import GraspFamily, grasp_scene

DEFAULT_FAMILY: GraspFamily = "packed"
"""Family of the demo: several upright objects close together."""
DEFAULT_OBJECTS = 5
"""Default number of objects. Clearing them takes about two minutes."""


@dataclass(frozen=True)
class DemoScene:
    """The objects of a demo and their source."""

    objects: tuple[TabletopObject | MeshObject, ...]
    """Solids at rest, or meshes at the poses from which they fall. The origin is the centre of the
    table top."""
    source: str
    """Description of the source for people."""
    family: GraspFamily
    """Arrangement of the objects."""
    folder: str = ""
    """Folder of the meshes; empty for solids."""


def demo_scene(scene: str, seed: int, objects: int | Path | None = None) -> DemoScene:
    """Draw a random scene or read one from a file.

    Parameters
    ----------
    scene
        A family, or a ground_truth.json of `eyehand synth` (or its folder).
    seed
        Seed of a random scene.
    objects
        Number of objects of a random scene, or a folder of meshes or URDFs to draw from. From a
        folder, at most DEFAULT_OBJECTS are drawn. The family single always has one object.

    Raises
    ------
    InputError
        If `scene` is neither a family nor a scene file, if the count is out of range, or if the
        folder holds no objects.
    """
    if scene not in get_args(GraspFamily):
        return _read_scene(scene, objects)
    family: GraspFamily = scene  # pyright: ignore[reportAssignmentType] - one of its names
    if isinstance(objects, Path):
        return _mesh_scene(family, seed, objects)
    if family == "single" and objects not in (None, 1):
        raise InputError(f"--scene single has 1 object, got --objects {objects}: try packed")
    if objects is None:
        objects = 1 if family == "single" else DEFAULT_OBJECTS
    if not 1 <= objects <= MAX_OBJECTS:
        raise InputError(f"--objects must be 1 to {MAX_OBJECTS}, got {objects}")
    drawn = grasp_scene(family, seed, objects).objects
    source = f"{counted(len(drawn), 'object')}, {family}, seed {seed}"
    return DemoScene(drawn, source, family)


def _mesh_scene(family: GraspFamily, seed: int, folder: Path) -> DemoScene:
    """Draw a scene of meshes or URDFs from a folder."""
    if not folder.is_dir():
        raise InputError(
            f"--objects {folder}: neither a number nor a folder of meshes (.obj, .stl) or URDFs"
        )
    objects = ObjectSource(str(folder))
    count = min(len(objects.read()), DEFAULT_OBJECTS)
    drawn = mesh_scene(objects, family, seed, count)
    source = f"{counted(len(drawn), 'object')} of {folder}, {family}, seed {seed}"
    return DemoScene(drawn, source, family, str(folder))


def _read_scene(scene: str, objects: int | Path | None) -> DemoScene:
    """Read a scene from a file or its folder."""
    path = Path(scene)
    if not path.exists():
        families = get_args(GraspFamily)
        meant = get_close_matches(scene, families, n=1)
        hint = f"did you mean {meant[0]}? " if meant else ""
        raise InputError(
            f"--scene {scene}: no such file; {hint}expected {', '.join(families)} or a scene file"
        )
    if objects is not None:
        raise InputError(f"--scene {scene} already defines the objects: leave --objects out")
    read = read_ground_truth(path)
    if read.table.height != 0.0:
        raise InputError(f"{path}: the table top must be at height 0 m, got {read.table.height}")
    return DemoScene(
        read.objects, f"{counted(len(read.objects), 'object')} of {path}", DEFAULT_FAMILY
    )

"""What stands on the demo's table: drawn by seed from solids or own meshes, or read from a file."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from eyehand.data_synth import read_ground_truth
from eyehand.data_synth.scenes import MAX_OBJECTS, read_objects
from eyehand.errors import InputError

from ..wording import counted
from .mesh_scenes import folder_scene
from .scenes import GraspFamily, grasp_scene

if TYPE_CHECKING:
    from eyehand.data_synth.scenes import MeshObject, TabletopObject

DEFAULT_FAMILY: GraspFamily = "packed"
"""Objects beside one another: what tables look like."""
USUAL_OBJECTS = 5
"""On a table where nothing else is said: two minutes to watch."""


@dataclass(frozen=True)
class DemoScene:
    """Objects for the table, and where they come from."""

    objects: tuple[TabletopObject | MeshObject, ...]
    """Solids at rest, meshes where they begin to fall; the table's top at z = 0, its middle at the
    origin."""
    source: str
    """Where they come from, in words."""
    family: GraspFamily
    """How they stand, as far as it was drawn."""
    folder: str = ""
    """Where their meshes were; empty for solids."""


def demo_scene(scene: str, seed: int, objects: int | Path | None = None) -> DemoScene:
    """Draw a scene, or read it.

    Parameters
    ----------
    scene
        A family, or a file (or its folder) as `eyehand synth` writes it.
    seed
        Of a drawn scene.
    objects
        Of a drawn scene: how many, or a folder of meshes or URDFs to draw from, as many as are in
        it, at most the usual number. A single one has always one.

    Raises
    ------
    InputError
        If it is neither a family nor a file with a scene, the count is out of range, or the folder
        holds no objects.
    """
    if scene not in get_args(GraspFamily):
        return _read_scene(scene, objects)
    family: GraspFamily = scene  # pyright: ignore[reportAssignmentType] - one of its names
    if isinstance(objects, Path):
        return _own_objects(family, seed, objects)
    if family == "single" and objects not in (None, 1):
        raise InputError(f"--scene single has 1 object, got --objects {objects}: try packed")
    if objects is None:
        objects = 1 if family == "single" else USUAL_OBJECTS
    if not 1 <= objects <= MAX_OBJECTS:
        raise InputError(f"--objects must be 1 to {MAX_OBJECTS}, got {objects}")
    drawn = grasp_scene(family, seed, objects)
    told = f"{counted(len(drawn.objects), 'object')}, {family}, seed {seed}"
    return DemoScene(drawn.objects, told, family)


def _own_objects(family: GraspFamily, seed: int, folder: Path) -> DemoScene:
    """Draw from meshes or URDFs."""
    if not folder.is_dir():
        raise InputError(
            f"--objects {folder}: neither a number nor a folder of meshes (.obj, .stl) or URDFs"
        )
    count = min(len(read_objects(folder)), USUAL_OBJECTS)
    drawn = folder_scene(folder, family, seed, count)
    told = f"{counted(len(drawn), 'object')} of {folder}, {family}, seed {seed}"
    return DemoScene(drawn, told, family, str(folder))


def _read_scene(scene: str, objects: int | Path | None) -> DemoScene:
    """Read a scene from a file or its folder."""
    path = Path(scene)
    if not path.exists():
        families = get_args(GraspFamily)
        meant = get_close_matches(scene, families, n=1)
        hint = f"did you mean {meant[0]}? There are" if meant else "give one of"
        raise InputError(
            f"--scene {scene}: no such file; {hint} {', '.join(families)} or a file's path"
        )
    if objects is not None:
        raise InputError(f"--scene {scene} tells what stands on the table: leave --objects out")
    read = read_ground_truth(path)
    if read.table.height != 0.0:
        raise InputError(f"{path}: the table's top must be at height 0 m, got {read.table.height}")
    return DemoScene(
        read.objects, f"{counted(len(read.objects), 'object')} of {path}", DEFAULT_FAMILY
    )

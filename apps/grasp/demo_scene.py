"""What stands on the demo's table: drawn by seed, or read from a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from eyehand.data_synth import read_ground_truth
from eyehand.data_synth.tabletop_options import MAX_OBJECTS
from eyehand.errors import InputError

from .scenes import GraspFamily, grasp_scene

if TYPE_CHECKING:
    from eyehand.data_synth.tabletop_scene import TabletopObject

DEFAULT_FAMILY: GraspFamily = "packed"
"""Objects beside one another: what tables look like."""


@dataclass(frozen=True)
class DemoScene:
    """Objects for the table, and where they come from."""

    objects: tuple[TabletopObject, ...]
    """At rest, the table's top at z = 0, its middle at the origin."""
    source: str
    """Where they come from, in words."""
    family: GraspFamily
    """How they stand, as far as it was drawn."""


def demo_scene(scene: str, seed: int, objects: int) -> DemoScene:
    """Draw a scene, or read it.

    Parameters
    ----------
    scene
        A family, or a file (or its folder) as `eyehand synth` writes it.
    seed
        Of a drawn scene.
    objects
        Objects of a drawn scene.

    Raises
    ------
    InputError
        If it is neither a family nor a file with a scene, or the count is out of range.
    """
    if scene in get_args(GraspFamily):
        family: GraspFamily = scene  # pyright: ignore[reportAssignmentType] - one of its names
        if not 1 <= objects <= MAX_OBJECTS:
            raise InputError(f"--objects must be 1 to {MAX_OBJECTS}, got {objects}")
        drawn = grasp_scene(family, seed, objects)
        count = len(drawn.objects)
        told = f"{count} object{'s' if count > 1 else ''}, {family}, seed {seed}"
        return DemoScene(drawn.objects, told, family)
    path = Path(scene)
    if not path.exists():
        families = ", ".join(get_args(GraspFamily))
        raise InputError(f"--scene {scene}: no such file; give one of {families} or a file's path")
    read = read_ground_truth(path)
    if read.table.height != 0.0:
        raise InputError(f"{path}: the table's top must be at height 0 m, got {read.table.height}")
    return DemoScene(read.objects, f"{len(read.objects)} objects of {path}", DEFAULT_FAMILY)

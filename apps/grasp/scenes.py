"""Scenes for grasping: single objects, packed tables and piles, by seed."""

from __future__ import annotations

from typing import Literal

from eyehand.data_synth import TabletopOptions, make_scene
from eyehand.data_synth.cell import scene_options
from eyehand.data_synth.scenes import TabletopScene
from eyehand.errors import InputError

GraspFamily = Literal["single", "packed", "pile"]
"""single: one object that stands; packed: several that stand close together; pile: dropped onto
one another."""

GRASPABLE_WIDTH = (0.02, 0.09)
"""Horizontal extents of the objects, m: what the hand spans with room to spare, down to what two
fingertips take."""
GRASPABLE_HEIGHT = (0.025, 0.18)
"""Their third extents, m."""
DENSITY = (200.0, 700.0)
"""Mass over volume, kg/m³: from cartons with air in them to fruit."""
WORK_AREA = (0.36, 0.34)
"""Where objects stand, m: the arm reaches over all of it from above and from the side."""
PACKED_GAP = 0.012
"""Least distance between packed objects, m: less than a finger's thickness with its clearance."""
PACKED_AREA = (0.26, 0.26)
"""Where packed objects stand, m."""


def grasp_scene(family: GraspFamily, seed: int, objects: int = 5) -> TabletopScene:
    """Draw a scene.

    Raises
    ------
    InputError
        If the family is unknown, or there is no object.
    """
    if objects < 1:
        raise InputError(f"a scene needs one object at least, got {objects}")
    if family == "single":
        options = _options("separate", 1, WORK_AREA, 0.015)
    elif family == "packed":
        options = _options("separate", objects, PACKED_AREA, PACKED_GAP)
    elif family == "pile":
        options = _options("piled" if objects > 1 else "dropped", objects, PACKED_AREA, 0.01)
    else:
        raise InputError(f"family must be one of single, packed, pile, got {family!r}")
    return make_scene(seed, options)


def _options(
    family: Literal["separate", "piled", "dropped"],
    objects: int,
    area: tuple[float, float],
    gap: float,
) -> TabletopOptions:
    return scene_options(
        family,
        (objects, objects),
        width_range=GRASPABLE_WIDTH,
        height_range=GRASPABLE_HEIGHT,
        work_area=area,
        min_gap=gap,
        density_range=DENSITY,
    )

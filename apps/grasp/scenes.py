"""Random scenes for grasping: single objects, packed objects and piles."""

from __future__ import annotations

from typing import Literal

from eyehand.data_synth import make_scene
from eyehand.data_synth.cell import scene_options
from eyehand.data_synth.scenes import TabletopScene
from eyehand.errors import InputError

GraspFamily = Literal["single", "packed", "pile"]
"""Arrangement of the objects. single: one upright object; packed: several upright objects close
together; pile: objects dropped onto each other."""

GRASPABLE_WIDTH = (0.02, 0.09)
"""Range of the horizontal extents of an object, m. The hand can span the widest with clearance; two
fingertips can hold the narrowest."""
GRASPABLE_HEIGHT = (0.025, 0.18)
"""Range of the heights of an object, m."""
DENSITY = (200.0, 700.0)
"""Range of the densities, kg/m³: from partly empty cartons to fruit."""
WORK_AREA = (0.36, 0.34)
"""Size of the work area, m. The arm reaches all of it from above and from the side."""
PACKED_GAP = 0.012
"""Minimum gap between packed objects, m. A finger with its clearance does not fit in."""
SINGLE_GAP, PILE_GAP = 0.015, 0.01
"""Minimum gaps of a single object and of a pile, m."""
PACKED_AREA = (0.26, 0.26)
"""Size of the area of packed objects, m."""


def grasp_scene(family: GraspFamily, seed: int, objects: int = 5) -> TabletopScene:
    """Draw a random scene of a family.

    Raises
    ------
    InputError
        If the family is unknown, or `objects` is less than 1.
    """
    if objects < 1:
        raise InputError(f"a scene needs at least 1 object, got {objects}")
    arrangement: Literal["separate", "piled", "dropped"] = "separate"
    area, gap = PACKED_AREA, PACKED_GAP
    if family == "single":
        objects, area, gap = 1, WORK_AREA, SINGLE_GAP
    elif family == "pile":
        arrangement, gap = "piled" if objects > 1 else "dropped", PILE_GAP
    elif family != "packed":
        raise InputError(f"family must be one of single, packed, pile, got {family!r}")
    options = scene_options(
        arrangement,
        (objects, objects),
        width_range=GRASPABLE_WIDTH,
        height_range=GRASPABLE_HEIGHT,
        work_area=area,
        min_gap=gap,
        density_range=DENSITY,
    )
    return make_scene(seed, options)

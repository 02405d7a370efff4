"""Sweeps of furniture: objects in clutter and in a bin, the rim of a tray, the size of a table."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from eyehand.data_synth import FurnishedOptions, FurnishedScene, make_furnished_scene, render_scene
from eyehand.data_synth.render import capture
from eyehand.data_synth.scenes import (
    Fixture,
    FurnishedFamily,
    TabletopObject,
    ViewOptions,
    camera_intrinsics,
    furniture,
    look_at,
)
from eyehand.perception import Superquadric

from ..bench import Trial, as_sweep
from .camera_sweeps import COLOURS, MM
from .dataset import slivers
from .score import score_segmentation
from .stress_trial import BASE_NOISE, SegmentCallable, TrialPicture, timed_segment, try_frame

GREY, WOOD = (0.55, 0.55, 0.56), (0.62, 0.5, 0.37)
MIN_HEAP_F = 0.75
"""Minimum overlap F of a heap. Some objects of a heap show so little that none can be required."""
MIN_KEPT = 0.8
"""Minimum share of the objects that stay on the furniture."""
DROP_M = 0.5
"""Height of the small table over the floor."""
DENSITY = 400.0
"""Density of the boxes, kg/m³. They do not move."""

holds_heap = partial(
    as_sweep, right=f"overlap F of at least {100 * MIN_HEAP_F:g} %, no furniture among the objects"
)
finds_boxes = partial(as_sweep, right="exactly the boxes found")


@holds_heap("clutter", "objects in clutter", "", (5, 8, 12, 16, 20), holds_to=5)
def _clutter(count: float, seed: int, method: SegmentCallable) -> Trial:
    return _try_heap(method, "clutter", int(count), seed)


@holds_heap("bin-fill", "objects in a bin", "", (2, 4, 8, 12, 18, 24), holds_to=None)
def _bin_fill(count: float, seed: int, method: SegmentCallable) -> Trial:
    return _try_heap(method, "bin", int(count), seed)


@finds_boxes("rim", "rim of a tray", "mm", (150, 80, 40, 20, 10, 5), holds_to=10)
def _rim(height: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 83])
    tray = furniture.container((0.4, 0.3), height * MM, GREY)
    table = furniture.table((1.2, 0.8), DROP_M, WOOD)
    floor = furniture.ground(-DROP_M, GREY)
    boxes = _boxes([(-0.1, -0.06), (0.1, -0.06), (-0.1, 0.07), (0.1, 0.07)], 4 * MM, rng)
    return _try_boxes(method, boxes, (*tray, *table, floor), 0.75, seed)


@finds_boxes("table-size", "side of a table over a floor", "mm", (600, 400, 300, 200, 150, 120),
             holds_to=300)  # fmt: skip
def _table_size(side: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 89])
    size = (side * MM, 0.8 * side * MM)
    parts = furniture.pedestal(size, DROP_M, WOOD, turned=False)
    place = 0.2 * side * MM
    places = [(-place, 0.0), (place, 0.0)] if side >= 300 else [(0.0, 0.0)]
    boxes = _boxes(places, 0.0, rng, largest=min(0.07, 0.35 * side * MM))
    return _try_boxes(method, boxes, (*parts, furniture.ground(-DROP_M, GREY)), 0.7, seed)


def _boxes(
    places: list[tuple[float, float]], z: float, rng: np.random.Generator, largest: float = 0.07
) -> tuple[TabletopObject, ...]:
    """Return upright boxes that stand at height `z` over the places."""
    objects = []
    for number, (x, y) in enumerate(places):
        half = rng.uniform(0.6, 1.0, 3) * largest / 2
        turn = Rotation.from_euler("Z", rng.uniform(0, np.pi))
        pose = RigidTransform.from_components([x, y, z + half[2]], turn)
        shape = Superquadric(half, (0.1, 0.1), pose, "box")
        mass = DENSITY * 8 * float(half.prod())
        objects.append(TabletopObject(f"box_{number + 1}", shape, mass, COLOURS[number]))
    return tuple(objects)


def _try_boxes(
    method: SegmentCallable,
    boxes: tuple[TabletopObject, ...],
    fixtures: tuple[Fixture, ...],
    distance: float,
    seed: int,
) -> Trial:
    rng = np.random.default_rng([seed, 97])
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(45, 65))
    level = np.cos(elevation)
    towards = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    camera = camera_intrinsics(ViewOptions())
    pose = look_at(distance * towards, np.zeros(3))
    scene = FurnishedScene(seed, "tray", boxes, fixtures, camera, pose)
    view = render_scene(scene)
    return try_frame(method, capture(scene, view, BASE_NOISE, rng), view.labels)


def _try_heap(method: SegmentCallable, family: FurnishedFamily, count: int, seed: int) -> Trial:
    scene = make_furnished_scene(seed, FurnishedOptions(family, (round(MIN_KEPT * count), count)))
    view = render_scene(scene)
    frame = capture(scene, view, BASE_NOISE, np.random.default_rng([seed, 101]))
    found, seconds, fault = timed_segment(method, frame)
    picture = TrialPicture(frame, found.labels, view.labels)
    if fault:
        return Trial(False, fault, clean=False, seconds=seconds, picture=picture)
    score = score_segmentation(found.labels, view.labels, slivers(view.labels) | ~frame.valid)
    note = ""
    if score.f < MIN_HEAP_F or score.false:
        note = f"F {100 * score.f:.0f} %, {score.false} false, {score.under} merged"
    return Trial(not note, note, score=score.f, seconds=seconds, picture=picture)


FURNISHED_SWEEPS = (_clutter, _bin_fill, _rim, _table_size)
"""Sweeps of clutter, bins, rims and small tables."""

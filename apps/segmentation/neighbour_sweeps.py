"""Sweeps of neighbouring objects: side by side, leaning, stacked, occluded."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from eyehand.data_synth.render import StagedObject, StagedScene, render_staged
from eyehand.data_synth.scenes import staged_solids as shapes

from ..bench import Trial, as_sweep
from .camera_sweeps import COLOURS, MM, view_around
from .stress_trial import SegmentCallable, try_scene

RED, BLUE, GREEN = COLOURS[:3]

finds_both = partial(as_sweep, right="exactly the 2 objects found")
finds_both_or_warns = partial(
    as_sweep, right="exactly the 2 objects found, or one marked as ambiguous"
)


@finds_both("gap", "gap between unequal boxes", "mm", (20, 15, 10, 6, 4, 3, 2, 1, 0), holds_to=0)
def _gap(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 11])
    wide, other = rng.uniform(0.05, 0.09, 2)
    tall, low = rng.uniform(0.08, 0.12), rng.uniform(0.04, 0.07)
    back = rng.uniform(0.012, 0.02)
    objects = (
        StagedObject(shapes.box(wide, 0.06, tall), (-(wide + gap * MM) / 2, 0.0, 0.0), colour=RED),
        StagedObject(
            shapes.box(other, 0.06, low), ((other + gap * MM) / 2, back, 0.0), colour=BLUE
        ),
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=25.0)), seed)


@finds_both(
    "gap-aligned",
    "gap between equal boxes in line",
    "mm",
    (20, 15, 10, 8, 6, 4, 3, 2, 1),
    holds_to=8,
)
def _gap_aligned(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 13])
    wide, deep, tall = rng.uniform(0.05, 0.09, 3)
    objects = tuple(
        StagedObject(
            shapes.box(wide, deep, tall), (side * (wide + gap * MM) / 2, 0.0, 0.0), colour=colour
        )
        for side, colour in ((-1, RED), (1, BLUE))
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=25.0)), seed)


@finds_both("lean", "gap at the top of a leaning box", "mm", (6, 5, 4, 3, 2, 1, 0), holds_to=0)
def _lean(gap: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 17])
    wide, tall = 0.03, rng.uniform(0.09, 0.12)
    lean = np.radians(rng.uniform(12, 25))
    # The lower right edge of the leaning box lies on the table, its upper right edge at the gap.
    lift = wide / 2 * np.sin(lean)
    touch = wide / 2 * np.cos(lean) + tall * np.sin(lean) + gap * MM
    back = rng.choice([-1, 1]) * rng.uniform(0.008, 0.015)
    objects = (
        StagedObject(shapes.box(wide, 0.06, tall), (0.0, 0.0, lift), lean=lean, colour=BLUE),
        StagedObject(shapes.box(0.06, 0.06, 0.13), (touch + 0.03, back, 0.0), colour=RED),
    )
    return try_scene(method, StagedScene(objects, view_around(rng, (35, 50), turn=40.0)), seed)


@finds_both_or_warns(
    "stack", "upper box inset on each side", "mm", (20, 15, 10, 8, 6, 4, 2, 0), holds_to=15
)
def _stack(inset: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 19])
    x, y = rng.uniform(0.08, 0.1, 2)
    low, high = rng.uniform(0.04, 0.07, 2)
    less = 2 * inset * MM
    objects = (
        StagedObject(shapes.box(x, y, low), colour=RED),
        StagedObject(shapes.box(x - less, y - less, high), (0.0, 0.0, low), colour=BLUE),
    )
    return try_scene(
        method, StagedScene(objects, view_around(rng, (25, 45), turn=40.0)), seed, ambiguous=True
    )


@finds_both_or_warns(
    "tapered-stack",
    "taper of two equal stacked solids",
    "°",
    (15, 12, 10, 8, 6, 4, 2, 0),
    holds_to=6,
)
def _tapered_stack(taper: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 23])
    x, y = rng.uniform(0.075, 0.095, 2)
    tall = rng.uniform(0.05, 0.065)
    less = 2 * tall * np.tan(np.radians(taper))
    solid = shapes.tapered_box((x, y), (x - less, y - less), tall)
    objects = (StagedObject(solid, colour=RED), StagedObject(solid, (0.0, 0.0, tall), colour=BLUE))
    return try_scene(
        method, StagedScene(objects, view_around(rng, (25, 45), turn=40.0)), seed, ambiguous=True
    )


@finds_both_or_warns(
    "flush", "step between touching boxes", "mm", (20, 15, 10, 8, 6, 4, 2, 0), holds_to=None
)
def _flush(step: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, _flush_scene(step, seed, same=True), seed, colour=True, ambiguous=True)


@finds_both(
    "flush-colour",
    "the same, boxes of two colours",
    "mm",
    (20, 15, 10, 8, 6, 4, 2, 0),
    holds_to=None,
)
def _flush_colour(step: float, seed: int, method: SegmentCallable) -> Trial:
    return try_scene(method, _flush_scene(step, seed, same=False), seed, colour=True)


def _flush_scene(step: float, seed: int, *, same: bool) -> StagedScene:
    """Return two boxes of equal height and depth side by side, one set back by `step` mm."""
    rng = np.random.default_rng([seed, 29])
    one, other = rng.uniform(0.05, 0.09, 2)
    deep, tall = rng.uniform(0.05, 0.08, 2)
    objects = (
        StagedObject(shapes.box(one, deep, tall), (-one / 2, 0.0, 0.0), colour=RED),
        StagedObject(
            shapes.box(other, deep, tall), (other / 2, step * MM, 0.0), colour=RED if same else BLUE
        ),
    )
    return StagedScene(objects, view_around(rng, (35, 50), turn=30.0))


@finds_both(
    "occluded-box",
    "bar in front of a 180 mm box",
    "mm",
    (10, 20, 30, 40, 60, 80, 100, 120, 140),
    holds_to=100,
)
def _occluded_box(width: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 31])
    behind = StagedObject(
        shapes.box(0.18, 0.06, rng.uniform(0.06, 0.08)), (0.0, 0.04, 0.0), colour=RED
    )
    return _behind_bar(behind, width, rng, seed, method)


@finds_both(
    "occluded-roll",
    "bar in front of a 180 mm roll",
    "mm",
    (10, 20, 30, 40, 60, 80, 100, 120, 140),
    holds_to=100,
)
def _occluded_roll(width: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 37])
    behind = StagedObject(shapes.rod(rng.uniform(0.03, 0.04), 0.18), (0.0, 0.04, 0.0), colour=RED)
    return _behind_bar(behind, width, rng, seed, method)


def _behind_bar(
    behind: StagedObject, width: float, rng: np.random.Generator, seed: int, method: SegmentCallable
) -> Trial:
    # The bar hides the far edge of the object behind it, even from the highest view of 32°.
    bar = StagedObject(shapes.box(width * MM, 0.015, 0.19), (0.0, -0.06, 0.0), colour=BLUE)
    view = view_around(rng, (24, 32), turn=6.0, target=(0.0, 0.0, 0.06))
    return try_scene(method, StagedScene((behind, bar), view), seed)


@finds_both(
    "border", "object area outside the image", "%", (0, 20, 40, 60, 70, 80, 90, 95), holds_to=80
)
def _border(share: float, seed: int, method: SegmentCallable) -> Trial:
    rng = np.random.default_rng([seed, 41])
    objects = (
        StagedObject(shapes.box(*rng.uniform(0.06, 0.1, 3)), yaw=rng.uniform(0, np.pi), colour=RED),
        StagedObject(shapes.cylinder(0.035, 0.07), (0.18, 0.22, 0.0), colour=BLUE),
    )
    scene = StagedScene(objects, view_around(rng, turn=10.0))
    rows, columns = np.nonzero(render_staged(scene, colour=False).labels == 1)
    # In odd scenes the lower image border cuts the object, in even scenes the left one.
    if seed % 2:
        down = scene.view.image_size[1] - 1 - np.quantile(rows, 1 - share / 100)
        shift = (0.0, float(np.round(down)))
    else:
        shift = (-float(np.round(np.quantile(columns, share / 100))), 0.0)
    if share == 0:
        shift = (0.0, 0.0)
    return try_scene(method, replace(scene, view=replace(scene.view, shift=shift)), seed)


NEIGHBOUR_SWEEPS = (
    _gap,
    _gap_aligned,
    _lean,
    _stack,
    _tapered_stack,
    _flush,
    _flush_colour,
    _occluded_box,
    _occluded_roll,
    _border,
)
"""Sweeps of gaps, leaning boxes, stacks, flush faces, occluders and the image border."""
